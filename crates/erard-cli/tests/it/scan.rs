//! `erard scan`, as a user has it.

use parquet::file::reader::SerializedFileReader;
use parquet::record::Field;
use serde_json::Value;

use crate::common::Folder;

/// A key that makes no note and one that plays two: cheap.
pub const CHEAP: [&str; 6] = ["scan", "two.mid", "--cases", "half-stroke", "--keys", "40"];
/// The file's own grand.
const OWN: [&str; 3] = ["--keyboard", "concert-grand", "--no-scatter"];

/// A column of a table that was written.
fn column(text: &str, name: &str) -> Vec<f64> {
    let index = text.lines().next().unwrap().split(',').position(|head| head == name).unwrap();
    text.lines().skip(1).map(|line| line.split(',').nth(index).unwrap().parse().unwrap()).collect()
}

/// A table's Parquet has the cells of its CSV: words, counts and numbers, and nothing where a cell is empty.
fn same_as_parquet(folder: &Folder, name: &str) {
    let text = folder.read(&format!("{name}.csv"));
    let mut lines = text.lines();
    let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
    let file = std::fs::File::open(folder.0.join(format!("{name}.parquet"))).unwrap();
    let rows: Vec<_> = SerializedFileReader::new(file).unwrap().into_iter().map(Result::unwrap).collect();
    assert_eq!(rows.len(), lines.clone().count(), "{name}");
    for (line, row) in lines.zip(&rows) {
        for ((cell, head), (title, field)) in line.split(',').zip(&heads).zip(row.get_column_iter()) {
            assert_eq!(head, title);
            match field {
                Field::Null => assert!(cell.is_empty(), "{head}: {cell}"),
                Field::Str(word) => assert_eq!(cell, word, "{head}"),
                Field::Int(number) => assert_eq!(cell, number.to_string(), "{head}"),
                Field::Double(number) => assert_eq!(cell.parse(), Ok(*number), "{head}"),
                other => panic!("{head}: {other}"),
            }
        }
    }
}

/// A data set of two sensors: `erard live`, which reads them, finds the true strikes and none in the half strokes.
#[test]
#[ignore = "ci: a scan, and 88 keys to read it"]
fn what_is_scanned_is_what_live_reads() {
    let folder = Folder::new("scan");
    std::fs::write(folder.0.join("two.mid"), crate::play::two_notes()).unwrap();
    let said = folder.good(&[&CHEAP[..], &OWN, &["--bits", "8,12", "--noise", "0", "--out", "set"]].concat());
    assert!(said.contains("piece") && said.contains("half-stroke"), "{said}");
    assert!(
        said.contains("Played: 3 notes and 3 motions.\nTruth: 2 impacts") && said.contains("Motions without"),
        "{said}"
    );
    let summary: Value = serde_json::from_str(&folder.read("set/scan.json")).unwrap();
    let scans = summary["scans"].as_array().unwrap();
    assert_eq!((scans.len(), &summary["keys"][0]["key"], &summary["sample"]), (2, &40.into(), &Value::Null));
    assert_eq!(summary["cases"][1]["impact_count"], 0, "{summary}");
    for scan in scans {
        let lines = folder.read(&format!("set/{}", scan["file"].as_str().unwrap())).lines().count();
        assert_eq!(lines as u64, scan["readings"].as_u64().unwrap() + 1);
    }
    let windows = folder.read("set/windows.csv");
    assert_eq!(column(&windows, "impact_count"), [1.0, 1.0, 0.0, 0.0, 0.0], "{windows}");
    same_as_parquet(&folder, "set/windows");
    same_as_parquet(&folder, "set/truth");

    let stream = "set/scan-12bit-1000hz-0.csv";
    let live = ["live", stream, "--calibration", "set/profile-12bit.toml", "--out-file", "notes.csv"];
    let said = folder.good(&live);
    assert!(said.contains("2 note-ons, 2 note-offs"), "{said}");
    assert!(!folder.0.join("notes.parquet").exists(), "a file that the user has named is that file alone");
    let (truth, found) = (folder.read("set/truth.csv"), folder.read("notes.csv"));
    assert_eq!(column(&truth, "key"), column(&found, "key"));
    for (name, most) in [("time_s", 1e-3), ("release_s", 1e-3), ("velocity", 1.5)] {
        let pairs = column(&truth, name).into_iter().zip(column(&found, name));
        pairs.for_each(|(one, other)| assert!((one - other).abs() < most, "{name}: {one} {other}"));
    }
}

/// Pieces, names and numbers that cannot be end in one error, and nothing is written.
#[test]
fn what_cannot_be_scanned_is_refused() {
    let folder = Folder::new("scan-bad");
    folder.file("text.mid", "no piece");
    for (arguments, part) in [
        (&["scan"][..], "PIECE.mid"),
        (&["scan", "nowhere.mid"], "nowhere.mid: cannot be read"),
        (&["scan", "text.mid"], "text.mid"),
        (&["scan", "--cases", "stroke,waltz"], "found `waltz`; expected `all` or names"),
        (&["scan", "--cases", "stroke", "--keys", "40,89"], "found key `89`"),
        (&["scan", "--cases", "--bits", "3"], "expected a whole number from 4 to 24"),
        (&["scan", "--cases", "--rate", "1e9"], "expected a frequency from 20 to 20000 Hz"),
        (&["scan", "--cases", "--noise", "nan"], "from 0 to 10"),
        (&["scan", "--cases", "--contacts", "6,3"], "--contacts: found 3 mm; expected depths"),
        (&["scan", "--cases", "--contacts", "3"], "--contacts: 1 contacts; expected 2 or 3"),
        (&["scan", "--cases", "--contacts", "3,8.5", "--bits", "8"], "cannot be used with"),
        (&["scan", "--cases", "--keyboard", "harpsichord"], "harpsichord"),
        (&["scan", "--cases", "--keyboard", "concert-grand:sample=0"], "sample"),
        (
            &["scan", "--cases", "--bits", "4,5,6,7,8,9,10,11,12,13,14", "--rate", "20,30,40,50,60,70,80,90,99,100"],
            "110 sensors",
        ),
    ] {
        let said = Folder::words(&folder.bad(arguments));
        assert!(said.contains(part), "{arguments:?}: {said}");
    }
}

mod nightly {
    use super::*;

    /// A sample's keys with a technician's scatter: every key is another instrument, the same each time.
    #[test]
    #[ignore = "nightly: a sample is drawn and keys are weighed, four times"]
    fn keys_of_a_sample_differ() {
        let folder = Folder::new("scan-sample");
        let set = |out: &str, more: &[&str]| {
            let arguments = ["scan", "--cases", "half-stroke", "--keys", "40,41", "--out", out];
            folder.good(&[&arguments[..], more].concat());
            let summary: Value = serde_json::from_str(&folder.read(&format!("{out}/scan.json"))).unwrap();
            assert_eq!(summary["sample"], 1);
            let digests = summary["keys"].as_array().unwrap().iter().map(|key| key["digest"].clone());
            (digests.collect::<Vec<Value>>(), folder.read(&format!("{out}/scan-12bit-1000hz-0.05.csv")))
        };
        let (first, readings) = set("one", &[]);
        assert_eq!(set("again", &["--threads", "1"]), (first.clone(), readings.clone()));
        let (other, _) = set("other", &["--seed", "2"]);
        let (plain, _) = set("plain", &["--no-scatter"]);
        assert!(first.iter().zip(other.iter().zip(&plain)).all(|(a, (b, c))| a != b && a != c && b != c));
    }
}
