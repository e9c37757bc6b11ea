//! `erard diagnose` as a technician uses it: a few readings, a table of keys, a sheet; and what it says when it cannot.

use serde_json::Value;

use crate::common::Folder;

fn folder(test: &str) -> Folder {
    Folder::for_command("diagnose", test)
}

fn read(folder: &Folder, file: &str) -> Value {
    serde_json::from_str(&folder.read(file)).unwrap()
}

/// D 58, U 18: friction and no weight line; names of other regions say the same; the page has the person's numbers.
#[test]
fn a_few_readings() {
    let folder = folder("few");
    let said = folder.good(&[
        "--key",
        "C4",
        "--dw",
        "58",
        "--up-weight",
        "18g",
        "--set-off",
        "3.5",
        "--drop",
        "0.2mm",
        "--serial",
        "S 7",
    ]);
    assert!(said.starts_with("C4 (key 40) - diagnosis of your readings"), "{said}");
    for told in [
        "20.0 g",
        "38.0 g",
        "Measure next:",
        "let-off button too low",
        "leverage left out: it needs",
        "is simulated on grands",
    ] {
        assert!(said.contains(told), "{told}: {said}");
    }
    assert!(said.lines().all(|line| line.chars().count() <= 100), "{said}");
    assert!(!said.contains("No key was named"), "{said}");
    let found = read(&folder, "erard-out-diagnose/diagnosis.json");
    let key = &found["keys"][0];
    // The page begins with what to do, in the trade's order: looks, friction with the reading that tells where it rubs,
    // what is named, and everything again. What the readings leave open is no work: it has its own heading.
    let to_do: Vec<&str> = key["to_do"].as_array().unwrap().iter().filter_map(|line| line.as_str()).collect();
    let begins = [
        "Look for a damp room",
        "Measure ",
        "Ease friction and weigh again",
        "Test for let-off button too low",
        "Take all readings again",
    ];
    assert!(to_do.len() == 5 && to_do.iter().zip(begins).all(|(line, word)| line.starts_with(word)), "{to_do:?}");
    assert!(said.contains("Friction is over 16 g: ease it and weigh again") && key["weigh_again"] == true, "{said}");
    assert_eq!(
        (key["key"].as_u64(), key["is_work"].as_bool(), key["inertia_kg"].is_null()),
        (Some(40), Some(true), true)
    );
    let causes: Vec<&str> = key["causes"].as_array().unwrap().iter().filter_map(|one| one["cause"].as_str()).collect();
    assert!(causes.contains(&"let_off_wide") && !causes.iter().any(|cause| cause.starts_with("leads")), "{causes:?}");
    let page = folder.read("erard-out-diagnose/diagnosis.html");
    assert!(
        page.contains("S 7")
            && page.contains("58.0 g")
            && page.contains("@page{size:A4}")
            && !page.contains("<script>")
    );
}

/// Where nobody names the key, the answer says whose ranges it took.
#[test]
fn a_key_that_was_not_named() {
    let folder = folder("unnamed");
    let said = folder.good(&["--down-weight", "58", "--up-weight", "18"]);
    assert!(said.contains("No key was named: usual ranges are those of C4 (key 40)"), "{said}");
    assert!(folder.read("erard-out-diagnose/diagnosis.html").contains("No key was named"));
}

/// Many keys, by number or note, with empty cells; the sound one gets no work, and a sharp's dip is not judged.
#[test]
fn a_table_of_keys() {
    let folder = folder("table");
    folder.file("piano.csv", "note;DW;UW;set-off;drop;dip\nA0;55;24;1,5;1,5;10\nC4;58;18;3,5;0;\n41;51;24;;;9,0\n");
    let said = folder.good(&["piano.csv"]);
    assert!(
        said.contains("3 keys, 1 of them with work") && said.contains("C4 (key 40)") && !said.contains("A0 (key"),
        "{said}"
    );
    let found = read(&folder, "erard-out-diagnose/diagnosis.json");
    let standing = found["keys"][2]["readings"].as_array().unwrap().iter().find(|one| one["name"] == "dip_mm").unwrap();
    assert_eq!(standing["standing"], "not_judged");
    assert_eq!(folder.read("erard-out-diagnose/diagnosis.csv").lines().count(), 4);
}

/// A piano as it was published (CAUT list, October 2004), with a column `N` and one that is not used: all keys say the
/// same, once, and `keyboard --measured` of the same table says it, too, and gives no lead.
#[test]
fn one_piano_one_cause() {
    let folder = folder("common");
    let table = "N,D,U,FW,SW,colour\n28,64,43,25.6,10.1,red\n40,65,41,25,9.8,\n41,63,41,26.9,9.7,\n52,57,36,24.2,8.9,\n64,58,39,15.6,8.2,\n";
    folder.file("piano.csv", table);
    let output = folder.erard(&["piano.csv", "--full"]);
    let (said, warned) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert!(said.contains("5 of 5 keys with work say the same, so that the cause is one: high"), "{said}");
    assert!(warned.contains("columns that were not used: colour"), "{warned}");
    let found = read(&folder, "erard-out-diagnose/diagnosis.json");
    assert_eq!((&found["common"][0]["cause"], found["common"].as_array().unwrap().len()), (&"ratio_high".into(), 1));
    assert!(found["common"][0]["section"].is_null());
    let all = Folder::new("common-weighed");
    all.file("piano.csv", table);
    let said = all.good(&["keyboard", "--measured", "piano.csv", "--checked-keys", "0", "--out", "work"]);
    assert!(said.contains("Leverage before hammers and leads: the ratio of 5 of 5 keys is out"), "{said}");
    assert!(said.contains("wait: first leverage") && said.contains("Columns that were not used: colour"), "{said}");
    assert!(!said.contains(" in 14 g") && !said.contains("to the front"), "{said}");
    let plan = read(&all, "work/weigh.json");
    assert_eq!((plan["work"].as_array().unwrap().len(), plan["leverage"]["of"].as_u64()), (0, Some(5)));
    let by_mm = plan["leverage"]["capstan_to_the_player_mm"].as_f64().unwrap();
    assert!((5.0..=8.0).contains(&by_mm), "{by_mm}");
}

/// A cause of one section is that section's; a reading off its neighbours' mean is named though it is in range.
#[test]
fn one_section_one_cause_and_neighbours() {
    let folder = folder("section");
    let mut table = "key,let_off_mm,drop_mm,blow_mm\n".to_owned();
    for key in [22, 24, 25, 27] {
        table += &format!("{key},4.2,1.5,46\n");
    }
    for (key, blow) in [(52, 46.0), (54, 46.1), (56, 44.2), (57, 46.0), (59, 45.9)] {
        table += &format!("{key},1.5,3.4,{blow}\n");
    }
    folder.file("piano.csv", &table);
    let said = folder.good_words(&["piano.csv"]);
    let found = read(&folder, "erard-out-diagnose/diagnosis.json");
    let sections: Vec<(&Value, &Value)> =
        found["common"].as_array().unwrap().iter().map(|one| (&one["cause"], &one["section"])).collect();
    let [low, high] = [serde_json::json!([21, 50]), serde_json::json!([51, 70])];
    assert_eq!(sections, [(&"let_off_wide".into(), &low), (&"drop_large".into(), &high)], "{said}");
    assert!(said.contains("4 of 4 keys with work from F2 to A#4 say the same"), "{said}");
    assert!(said.contains("E5 (key 56): blow -1.8 mm"), "{said}");
    let blow =
        |key: usize| found["keys"][key]["readings"].as_array().unwrap().iter().find(|one| one["name"] == "blow_mm");
    assert_eq!(blow(6).unwrap()["neighbours"], 46.0);
    assert!(folder.read("erard-out-diagnose/diagnosis.csv").contains("blow_mm=-1.8"));
}

/// Conditions of the weighing: weights at the key's edge count more, springs are in the leverage, the key alone has its
/// friction, and a damper in the weights is refused.
#[test]
fn conditions_of_the_weighing() {
    let folder = folder("conditions");
    let value = |name: &str| {
        let found = read(&folder, "erard-out-diagnose/diagnosis.json");
        let readings = found["keys"][0]["readings"].as_array().unwrap().clone();
        readings.iter().find(|one| one["name"] == name).and_then(|one| one["value"].as_f64())
    };
    folder.good(&["--down-weight", "50", "--up-weight", "25", "--measured-at", "0"]);
    assert_eq!((value("down_weight_g"), value("up_weight_g")), (Some(52.6), Some(26.3)));
    folder.good(&["--down-weight", "50", "--up-weight", "25", "--measured-at", "0.5in"]);
    assert!((value("down_weight_g").unwrap() - 50.06).abs() < 1e-9);
    let weights = ["--down-weight", "41", "--up-weight", "17", "--strike-weight", "10", "--front-weight", "26"];
    folder.good(&[&weights[..], &["--assist", "9"]].concat());
    assert!((value("strike_weight_ratio").unwrap() - 5.45).abs() < 0.1, "{:?}", value("strike_weight_ratio"));
    folder.good(&["--down-weight", "9", "--up-weight", "3", "--stack-on", "no"]);
    assert_eq!((value("key_alone_friction_g"), value("down_weight_g")), (Some(3.0), None));
    let said = folder.good_words(&["--bw", "38", "--f", "17", "--tapped", "no"]);
    assert!(said.contains("may be 2 g less") && said.contains("no work"), "{said}");
    for (arguments, told) in [
        (&["--down-weight", "60", "--dampers-lifted", "no"][..], "weights with the pedal down"),
        (&["--down-weight", "60", "--tapped", "7"], "--tapped 7: expected yes or no"),
        (&["--down-weight", "60", "--measured-at", "70"], "a number from 0 to 60 mm"),
    ] {
        let error = folder.bad(arguments);
        assert!(error.contains(told), "{error}");
    }
    folder.file("piano.csv", "N;D;U;Dampers lifted\n40;60;30;no\n");
    assert!(folder.bad(&["piano.csv"]).contains("piano.csv:2: column `dampers_lifted`"));
}

/// Whatever is wrong is said with its place and with what to give instead, and nothing is written.
#[test]
fn what_is_wrong_is_named() {
    let folder = folder("wrong");
    folder.file("empty.csv", "");
    folder.file("swapped.csv", "key,DW,UW\n40,18,58\n");
    folder.file("cut.csv", "key,DW,UW\n40,58,18\n41,5");
    folder.file("other.json", "{\"a\": 1}");
    for (arguments, told) in [
        (&[][..], "no reading was given; expected options such as --down-weight 58"),
        (&["missing.csv"], "missing.csv"),
        (
            &["cut.csv"],
            "cut.csv:3: 2 cells where the header has 3: the row is cut short; expected a cell for every column",
        ),
        (&["empty.csv"], "empty.csv: the file is empty; expected a header such as"),
        (&["swapped.csv"], "swapped.csv:2: column `up_weight_g`"),
        (&["other.json"], "expected the measure.json of `erard measure`"),
        (&["swapped.csv", "--drop", "1"], "found readings both in a table and as options"),
        (&["--down-weight", "18", "--up-weight", "58"], "are they swapped?"),
        (&["--drop=-1"], "--drop -1: expected a number from 0 to 40 mm"),
        (&["--drop", "much"], "--drop much: expected a number"),
        (&["--key", "H4", "--drop", "1"], "a note from A0 to C8"),
        (&["--drop", "1", "--leads", "14"], "--leads 14: expected grams"),
        (&["--drop", "1", "--leads", "14,5@165,14@147"], "type `14.5@165, 14@147` or `14,5@165; 14@147`"),
    ] {
        let error = folder.bad(arguments);
        assert!(error.contains(told), "{arguments:?}: {error}");
    }
}
