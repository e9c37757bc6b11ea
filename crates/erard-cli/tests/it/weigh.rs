//! `erard keyboard --weigh` as a technician uses it: from a table of weights to a work list.

use crate::common::Folder;
use serde_json::Value;

/// A piano with a ratio of 5.6, whose keys have a balance weight of 40 g in the bass and 36 g in the treble; key 30 was
/// not weighed, key 40 only in part; key 50's hammer is a gram too heavy for its neighbours. Decimal commas, as a
/// spreadsheet writes them here.
fn piano() -> String {
    let mut table = String::from("key;SW;FW;DW;UW\n");
    for key in (1..=88).filter(|key| *key != 30) {
        let x = f64::from(key);
        let strike = 10.6 - 0.065 * x + if key == 50 { 1.0 } else { 0.0 };
        let balance = 40.0 - 4.0 * (x - 1.0) / 87.0;
        let friction = 15.0 - 5.0 * (x - 1.0) / 87.0;
        // What balances at that, with KR WW of 10.3 g.
        let front = 10.3 + 5.6 * strike - balance;
        let cells =
            [strike, front, balance + friction, balance - friction].map(|g| format!("{g:.2}").replace('.', ","));
        let [strike, front, down, up] = cells;
        let (strike, front) = if key == 40 { (String::new(), front) } else { (strike, front) };
        table += &format!("{key};{strike};{front};{down};{up}\n");
    }
    table
}

fn read(folder: &Folder, file: &str) -> Value {
    serde_json::from_str(&folder.read(file)).unwrap()
}

/// The statics of every key by hand: balance weight, friction, leads whose moment makes the difference to the target;
/// and the sample in the dynamic model agrees to half a gram.
#[test]
fn a_work_list() {
    let folder = Folder::new("weigh");
    folder.file("piano.csv", &piano());
    let arguments =
        ["keyboard", "--weigh", "piano.csv", "--target", "balance=38g", "--sample", "2", "--serial", "D 1234"];
    let said = folder.good(&[&arguments[..], &["--out", "work"]].concat());
    assert!(said.starts_with("Concert grand - 87 keys weighed in piano.csv"), "{said}");
    // Every key that was weighed has its line.
    assert_eq!(
        said.lines().filter(|line| line.contains(" forward") || line.contains(" back")).count(),
        87 + 2,
        "{said}"
    );
    let plan = read(&folder, "work/weigh.json");
    assert_eq!(plan["target_balance_weight_g"], 38.0);
    let keys = plan["keys"].as_array().unwrap();
    for one in keys {
        let number = |key: &str| one[key].as_f64().unwrap();
        let x = number("key");
        let balance = 40.0 - 4.0 * (x - 1.0) / 87.0;
        assert!((number("balance_weight_g") - balance).abs() < 0.02, "{one}");
        assert!((number("friction_weight_g") - (15.0 - 5.0 * (x - 1.0) / 87.0)).abs() < 0.02, "{one}");
        // A gram in front is a gram of balance weight less; leads make it, at 265 mm, to a quarter of a gram.
        let leads = one["leads"].as_object().unwrap();
        let moment: f64 = leads["put"]
            .as_array()
            .unwrap()
            .iter()
            .map(|lead| lead[0].as_f64().unwrap() * lead[1].as_f64().unwrap())
            .sum();
        let wanted = if (balance - 38.0).abs() < 0.5 { 0.0 } else { balance - 38.0 };
        assert!((moment / 265.0 - wanted).abs() < 0.27, "{one}");
        let after = number("balance_weight_after_leads_g");
        assert!((after - 38.0).abs() < 0.52, "{one}");
    }
    // Key 40's hammer comes from the curve; its neighbours' line says 8.0 g.
    let middle = keys.iter().find(|one| one["key"] == 40).unwrap();
    assert_eq!(middle["from_curves"], true);
    let curve = plan["curves"].as_array().unwrap();
    let at = |key: usize| curve[key - 1]["strike_weight_g"].as_f64().unwrap();
    assert!((at(40) - (10.6 - 0.065 * 40.0)).abs() < 0.02, "{}", at(40));
    // The key that was not weighed has its aims, and the heavy hammer bends nothing.
    assert!((at(30) - (10.6 - 0.065 * 30.0)).abs() < 0.02 && (at(50) - (10.6 - 0.065 * 50.0)).abs() < 0.02);
    assert!(said.contains("off their curve") && said.contains("A#4"), "{said}");
    assert!(plan["checked"].as_array().unwrap().len() >= 4);
    assert!(plan["largest_difference_g"].as_f64().unwrap() < 0.5, "{plan}");
    let page = folder.read("work/weigh.html");
    assert!(page.contains("D 1234") && page.contains("@page{size:A4}") && page.matches("<tr>").count() == 88, "{page}");
    assert!(folder.read("work/weigh.csv").lines().count() == 88);
    assert!(std::fs::read(folder.0.join("work/weigh.png")).unwrap().starts_with(b"\x89PNG"));
}

/// An inertia as a target asks for hammers that have it, and the leads balance them.
#[test]
fn a_target_inertia() {
    let folder = Folder::new("weigh-inertia");
    folder.file("piano.csv", &piano());
    let arguments = ["keyboard", "--weigh", "piano.csv", "--target", "inertia=0.28kg", "--target", "balance=38g"];
    folder.good(&[&arguments[..], &["--sample", "0", "--out", "work", "--paper", "letter", "--inches"]].concat());
    let plan = read(&folder, "work/weigh.json");
    let mut reached = 0;
    for one in plan["keys"].as_array().unwrap().iter().filter(|one| one["from_curves"] == false) {
        if let Some(after) = one["inertia_after_leads_kg"].as_f64() {
            // The leads' places are not the ones that the estimate of the key's own inertia has.
            assert!((after - 0.28).abs() < 0.02, "{one}");
            reached += 1;
        }
    }
    assert!(reached > 40, "{reached}");
    assert!(folder.read("work/weigh.html").contains("size:letter") && folder.read("work/weigh.html").contains(" in"));
}

/// Whatever is wrong is said with its place, and nothing is written.
#[test]
fn what_is_wrong_is_named() {
    let folder = Folder::new("weigh-wrong");
    folder.file("piano.csv", &piano());
    folder.file("bad.csv", "key,SW\n1,heavy\n");
    folder.file("half.csv", "key,SW\n1,9\n");
    for (arguments, told) in [
        (&["--weigh", "missing.csv"][..], "missing.csv"),
        (&["--weigh", "bad.csv"], "bad.csv:2: column `sw`: `heavy`; expected a number from 1 to 30 g"),
        (&["--weigh", "half.csv"], "expected --target balance=38g"),
        (&["--weigh", "piano.csv", "--target", "balance=heavy"], "expected balance= and a number from 10 to 90 g"),
        (&["--weigh", "piano.csv", "--target", "speed=3"], "balance=38g or inertia=0.25kg"),
        (&["--weigh", "piano.csv", "--target", "balance=38", "--target", "balance=39"], "given twice"),
        (&["--weigh", "piano.csv", "--leads", "0.1"], "masses from 1 to 50 g"),
        (&["--target", "balance=38g"], "--weigh"),
    ] {
        let error = folder.bad(&[&["keyboard"][..], arguments].concat());
        assert!(error.contains(told), "{arguments:?}: {error}");
    }
}
