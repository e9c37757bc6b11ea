//! `erard keyboard --measured` as a technician uses it: from a table of weights to a work list.

use crate::common::Folder;
use serde_json::Value;

/// Some keys of a piano: at middle C it rubs, C6 has lost a lead, and G5's hammer is too heavy.
pub const FEW_KEYS: &str = "\
key,strike_weight_g,front_weight_g,down_weight_g,up_weight_g,leads
A0,10.4,31.5,53,21,
E2,9.7,28,52,22,
G3,9.1,25,50,24,
C4,8.7,22.5,58,18,14@164 14@146
D4,8.7,22.5,48,24,
G5,8.4,14.5,54,32,
A5,7.3,14.5,47,26,
C6,7.0,8,52,31,10@100
C8,4.8,0.5,47,27,
";

/// A piano with a ratio of 5.6, whose keys have a balance weight of 44 g in the bass and 32 g in the treble; key 30 was
/// not weighed, key 40 only in part; key 50's hammer is a gram too heavy for its neighbours. Decimal commas, as a
/// spreadsheet writes them here.
fn piano() -> String {
    let mut table = String::from("key;SW;FW;DW;UW\n");
    for key in (1..=88).filter(|key| *key != 30) {
        let x = f64::from(key);
        let strike = 10.6 - 0.065 * x + if key == 50 { 1.0 } else { 0.0 };
        let balance = 44.0 - 12.0 * (x - 1.0) / 87.0;
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

/// A piano whose leverage is too high at every key (published of three grands: ratios of 6.8 to 7.9): hammers and leads
/// wait, nothing is promised of them, and what is checked in the dynamic model is the move that comes first.
#[test]
fn what_waits_is_not_promised() {
    let folder = Folder::new("weigh-wait");
    folder.file("high.csv", "key,D,U,FW,SW\n1,79,48,41,12\n40,65,41,25,9.8\n60,62,40,15,8.1\n88,67,46,-8.6,5.5\n");
    let said = folder.good(&["keyboard", "--measured", "high.csv", "--checked-keys", "2", "--out", "work", "--full"]);
    let words = Folder::words(&said);
    assert!(
        words.contains("The capstan line 8.0 mm to the player") && words.contains("wait: first leverage"),
        "{said}"
    );
    assert!(words.contains("Checked, C8: capstan 8.0 mm forward") && !words.contains("Nothing to do"), "{said}");
    let plan = read(&folder, "work/weigh.json");
    let [keys, checked] = ["keys", "checked"].map(|part| plan[part].as_array().unwrap());
    assert!(keys.iter().all(|key| key["balance_weight_after_g"].is_null()), "{plan}");
    assert_eq!(checked.len(), 2);
    for one in checked {
        let [equation, model] =
            ["by_equation", "in_model"].map(|from| one[format!("balance_weight_{from}_g")].as_f64());
        let (equation, model) = (equation.unwrap(), model.unwrap());
        assert!(one["remedy"] == "capstan" && equation < -5.0 && (equation - model).abs() < 1.5, "{one}");
    }
}

/// The statics of every key by hand: balance weight, friction, leads whose moment makes the difference to the target;
/// and the sample in the dynamic model agrees to half a gram.
#[test]
fn a_work_list() {
    let folder = Folder::new("weigh");
    folder.file("piano.csv", &piano());
    let arguments =
        ["keyboard", "--measured", "piano.csv", "--target", "balance=38g", "--checked-keys", "2", "--serial", "D 1234"];
    let said = folder.good(&[&arguments[..], &["--out", "work"]].concat());
    assert!(said.starts_with("piano.csv - 87 keys weighed"), "{said}");
    assert!(said.lines().all(|line| line.chars().count() <= 100), "{said}");
    let plan = read(&folder, "work/weigh.json");
    assert_eq!((plan["target_balance_weight_g"].as_f64(), &plan["target_from"]), (Some(38.0), &"asked".into()));
    let (keys, work) = (plan["keys"].as_array().unwrap(), plan["work"].as_array().unwrap());
    let line = |key: &Value, operation: &str| {
        work.iter().find(|line| line["key"] == *key && line["operation"] == operation).cloned()
    };
    for one in keys {
        let number = |key: &str| one[key].as_f64().unwrap();
        let x = number("key");
        let balance = 44.0 - 12.0 * (x - 1.0) / 87.0;
        assert!((number("balance_weight_g") - balance).abs() < 0.02, "{one}");
        assert!((number("friction_weight_g") - (15.0 - 5.0 * (x - 1.0) / 87.0)).abs() < 0.02, "{one}");
        // The hammer of key 50 comes to its neighbours first: a gram of it is 5.6 g at the key.
        let hammer = line(&one["key"], "hammers");
        assert_eq!(hammer.is_some(), x == 50.0, "{one}");
        let wanted = balance - 38.0 - if x == 50.0 { 5.6 } else { 0.0 };
        // A gram in front is a gram of balance weight less; leads make it, at 265 mm, to a quarter of a gram.
        let Some(leads) = line(&one["key"], "leads") else {
            assert!(wanted.abs() < 2.1, "{one}");
            continue;
        };
        assert!(wanted.abs() > 1.9, "{one}");
        let by = leads["by_g"].as_f64().unwrap();
        assert!((by - wanted).abs() < 0.4, "{leads}");
        // Where weight must go and nobody said which leads are there, none is named.
        if let Some(put) = leads["leads"]["put"].as_array() {
            let moment: f64 = put.iter().map(|lead| lead[0].as_f64().unwrap() * lead[1].as_f64().unwrap()).sum();
            assert!((moment / 265.0 - wanted).abs() < 0.27, "{leads}");
        } else {
            assert!(wanted < 0.0, "{leads}");
        }
        let then = |key: &str| leads["then"][key].as_f64().unwrap();
        let after = 0.5 * (then("down_weight_g") + then("up_weight_g"));
        assert!((after - 38.0).abs() < 0.52 && (number("balance_weight_after_g") - after).abs() < 0.2, "{leads}");
    }
    // Every line of the list is printed, and the ends of the sections come first.
    let leads: Vec<u64> =
        work.iter().filter(|l| l["operation"] == "leads").map(|l| l["key"].as_u64().unwrap()).collect();
    assert!(leads.len() > 40 && leads[..4] == [1, 20, 21, 50], "{leads:?}");
    assert!(said.contains("samples at section ends") && said.contains("the rest"), "{said}");
    // Key 40's hammer comes from the curve; its neighbours' line says 8.0 g.
    let middle = keys.iter().find(|one| one["key"] == 40).unwrap();
    assert_eq!(middle["from_curves"], true);
    let curve = plan["curves"].as_array().unwrap();
    let at = |key: usize| curve[key - 1]["strike_weight_g"].as_f64().unwrap();
    assert!((at(40) - (10.6 - 0.065 * 40.0)).abs() < 0.02, "{}", at(40));
    // The key that was not weighed has its aims, and the heavy hammer bends nothing.
    assert!((at(30) - (10.6 - 0.065 * 30.0)).abs() < 0.02 && (at(50) - (10.6 - 0.065 * 50.0)).abs() < 0.02);
    assert!(said.contains("Strike weight that sticks out, g: A#4 8.3 (neighbours 7.3)"), "{said}");
    assert!(plan["checked"].as_array().unwrap().len() >= 4);
    assert!(plan["largest_difference_g"].as_f64().unwrap() < 0.5, "{plan}");
    let page = folder.read("work/weigh.html");
    assert!(
        page.contains("D 1234") && page.contains("@page{size:A4}") && page.matches("<tr>").count() > 88 + leads.len(),
        "{page}"
    );
    assert!(folder.read("work/weigh.csv").lines().count() == 88);
    assert!(std::fs::read(folder.0.join("work/weigh.png")).unwrap().starts_with(b"\x89PNG"));
}

/// 88 keys with springs at the whippens that take 9 g off. Ratio and down-weight without springs are the equation's,
/// and every remedy is within bounds: leads inside the key, capstans within 8 mm, strike weights near their range,
/// springs from 0 to 15 g. What is withheld has its reason, and another remedy stays.
#[test]
fn eighty_eight_keys_with_springs() {
    let folder = Folder::new("weigh-springs");
    let is_sharp = |key: usize| [1, 3, 6, 8, 10].contains(&((key + 8) % 12));
    let mut table = "N,SW,FW,BW,F,assist\n".to_owned();
    // Balance weights from 28 to 58 g: the lightest and the heaviest keys need more than any remedy may do.
    let balance = |key: usize| 28.0 + f64::from((7 * key as u32) % 31);
    let ratio = |key: usize| if is_sharp(key) { 6.18 } else { 5.7 };
    for key in 1..=88 {
        let strike = 11.0 - 0.067 * key as f64;
        let front = 10.3 + ratio(key) * strike - balance(key) - 9.0;
        table += &format!("{key},{strike:.2},{front:.2},{:.1},11,9\n", balance(key));
    }
    folder.file("piano.csv", &table);
    let arguments = ["keyboard", "--measured", "piano.csv", "--target", "balance=38g", "--checked-keys", "3"];
    let said = folder.good_words(&[&arguments[..], &["--out", "work"]].concat());
    let plan = read(&folder, "work/weigh.json");
    let (keys, work) = (plan["keys"].as_array().unwrap(), plan["work"].as_array().unwrap());
    assert_eq!(keys.len(), 88);
    let (mut withheld, mut offered) = (0, 0);
    for one in keys {
        let number = |name: &str| one[name].as_f64();
        let key = one["key"].as_u64().unwrap() as usize;
        assert_eq!(number("down_weight_without_assist_g"), Some(balance(key) + 11.0 + 9.0));
        // KR WW is the keyboard's own, 10.3 g but for the sharps' shorter keys.
        assert!((number("ratio").unwrap() - ratio(key)).abs() < 0.45, "{one}");
        assert!(number("capstan_to_the_player_mm").is_none_or(|mm| mm.abs() <= 8.0), "{one}");
        assert!(number("assist_change_g").is_none_or(|g| (0.0..=15.0).contains(&(9.0 + g))), "{one}");
        let strike = 11.0 - 0.067 * key as f64;
        assert!(number("strike_weight_change_g").is_none_or(|g| (4.0..=13.7).contains(&(strike + g))), "{one}");
        withheld += one["withheld"].as_array().unwrap().len();
        let names = ["capstan_to_the_player_mm", "assist_change_g", "strike_weight_change_g"];
        offered += names.iter().filter(|name| !one[**name].is_null()).count();
    }
    assert!(withheld > 20 && offered > 88, "{withheld} {offered}");
    let mut leads = 0;
    for line in work.iter().filter(|line| line["operation"] == "leads") {
        let by_g = line["by_g"].as_f64().unwrap();
        for put in line["leads"]["put"].as_array().into_iter().flatten() {
            // The farthest lead stands before the front pin of the shortest sharp.
            assert!(put[1].as_f64().unwrap().abs() < 210.0 && by_g.abs() < 60.0, "{line}");
            leads += 1;
        }
        assert!(line["then"]["front_weight_g"].as_f64().unwrap() < 41.4, "{line}");
    }
    assert!(leads > 20, "{leads}");
    for told in
        ["Springs or magnets are in the equation", "Springs left, for", "of aftertouch, and blow and dip are set anew"]
    {
        assert!(said.contains(told), "{told}: {said}");
    }
}

/// 20 g of friction are not answered with "leave": it is eased first, everything else of that key waits, and its own
/// balance weight is not the aim.
#[test]
fn friction_comes_first() {
    let folder = Folder::new("weigh-friction");
    folder.file("lone.csv", "key,DW,UW\nC4,58,18\n");
    let said = folder.good(&["keyboard", "--measured", "lone.csv", "--out", "work"]);
    assert!(said.contains("20.0 !") && said.contains("ease 10 g"), "{said}");
    let plan = read(&folder, "work/weigh.json");
    assert_eq!(plan["work"].as_array().unwrap().len(), 1);
    assert_eq!((&plan["keys"][0]["friction_is_out"], &plan["target_from"]), (&true.into(), &"trade".into()));
    let aim = plan["target_balance_weight_g"].as_f64().unwrap();
    assert_eq!(aim, 38.0);
}

/// The list is carried out and the keys weighed again, twice: nothing is left to do, and every weight is where it
/// should be.
#[test]
#[ignore = "ci: nine keys worked on twice"]
fn the_list_carried_out_leaves_nothing_to_do() {
    let folder = Folder::new("weigh-again");
    folder.file("piano.csv", FEW_KEYS);
    let mut file = "piano.csv".to_owned();
    let mut lines = Vec::new();
    for pass in ["one", "two", "three"] {
        folder.good(&["keyboard", "--measured", &file, "--checked-keys", "0", "--simulate-work", "--out", pass]);
        let plan = read(&folder, &format!("{pass}/weigh.json"));
        let work = plan["work"].as_array().unwrap();
        lines.push(work.iter().map(|one| format!("{} {}", one["operation"], one["note"])).collect::<Vec<_>>());
        for line in work {
            let again = plan["again"].as_array().unwrap().iter().find(|one| one["key"] == line["key"]).unwrap();
            let last = work.iter().rfind(|one| one["key"] == line["key"]).unwrap();
            for weight in ["down_weight_g", "up_weight_g", "strike_weight_g", "front_weight_g"] {
                let (then, found) = (last["then"][weight].as_f64().unwrap(), again[weight].as_f64().unwrap());
                // The ratio of the equation is not the model's: a gram of hammer may be half a gram off at the key.
                assert!((then - found).abs() < 1.5, "{weight}: {last} {again}");
            }
        }
        file = format!("{pass}/again.csv");
    }
    assert!(lines[0].iter().any(|line| line.contains("friction") && line.contains("C4")), "{lines:?}");
    assert!(lines[0].iter().any(|line| line.contains("hammers") && line.contains("G5")), "{lines:?}");
    assert!(lines[0].iter().any(|line| line.contains("leads") && line.contains("C6")), "{lines:?}");
    assert!(lines[2].is_empty(), "{lines:?}");
}

/// An inertia as a target asks for hammers that have it, and the leads balance them.
#[test]
fn a_target_inertia() {
    let folder = Folder::new("weigh-inertia");
    folder.file("piano.csv", &piano());
    let arguments = ["keyboard", "--measured", "piano.csv", "--target", "inertia=0.28kg", "--target", "balance=38g"];
    folder.good(&[&arguments[..], &["--checked-keys", "0", "--out", "work", "--paper", "letter", "--inches"]].concat());
    let plan = read(&folder, "work/weigh.json");
    let mut reached = 0;
    for one in plan["keys"].as_array().unwrap().iter().filter(|one| one["from_curves"] == false) {
        if let Some(after) = one["inertia_after_kg"].as_f64() {
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
    folder.file("cut.csv", "key,SW,FW\n1,9,20\n2,9\n");
    folder.file("open.csv", "key,SW,leads\n1,9,\"14@165\n");
    for (arguments, told) in [
        (&["--measured", "missing.csv"][..], "missing.csv"),
        (&["--measured", "bad.csv"], "bad.csv:2: column `sw`: `heavy`; expected a number from 1 to 30 g"),
        (
            &["--measured", "cut.csv"],
            "cut.csv:3: 2 cells where the header has 3: the row is cut short; expected a cell",
        ),
        (&["--measured", "open.csv"], "open.csv:2: a quote is not closed on its line"),
        (&["--measured", "half.csv"], "expected --target balance=38g"),
        (&["--measured", "piano.csv", "--target", "balance=heavy"], "expected balance= and a number from 10 to 90 g"),
        (&["--measured", "piano.csv", "--target", "speed=3"], "balance=38g, ratio=5.8 or inertia=0.25kg"),
        (&["--measured", "piano.csv", "--target", "balance=38", "--target", "balance=39"], "given twice"),
        (&["--measured", "piano.csv", "--lead-masses", "0.1"], "masses from 1 to 50 g"),
        (&["--target", "balance=38g"], "--measured"),
        (&["--measured", "piano.csv", "--sections", "20,H9"], "a note from A0 to C8"),
    ] {
        let error = folder.bad(&[&["keyboard"][..], arguments].concat());
        assert!(error.contains(told), "{arguments:?}: {error}");
    }
}
