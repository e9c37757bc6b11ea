//! Samples and bands as a user asks for them.

use std::fs;
use std::process::Output;

use crate::common::Folder;
use serde_json::Value;

/// The command with a cache of its own, which is there afterwards.
fn cached(folder: &Folder, arguments: &[&str]) -> Output {
    folder.command(arguments).env("XDG_CACHE_HOME", folder.0.join("cache")).output().unwrap()
}

/// What is no sample, no number of samples, or a band of what has none: one line, code 2, nothing written.
#[test]
fn what_cannot_be_sampled_is_refused() {
    let folder = Folder::new("samples-bad");
    for number in ["0", "", "x", "-3", "1000001", "1:sample=2"] {
        let told = folder.bad(&["press", "--instrument", &format!("concert-grand:sample={number}")]);
        assert!(told.contains("`; expected a number from 1 to 1000000"), "{number}: {told}");
    }
    let told = folder.bad(&["list", "concert-grand:key=89:sample=3"]);
    assert!(told.contains("found key `89`"), "{told}");
    assert!(folder.bad(&["list", "harpsichord:sample=3"]).contains("harpsichord"));
    for number in ["1", "0", "x", "-5", "10001"] {
        let told = folder.bad(&["press", &format!("--bands={number}")]);
        assert!(told.contains("--bands"), "{number}: {told}");
    }
    let told = folder.bad(&["press", "--instrument", "concert-grand:sample=3", "--bands=3"]);
    assert!(told.contains("is one sample; --bands needs many"), "{told}");
    let told = folder.bad(&["measure", "concert-grand", "steinway-o", "--bands=3"]);
    assert!(told.contains("--bands needs one instrument; found 2"), "{told}");
    let told = folder.bad(&["press", "--against", "ff", "--bands=3"]);
    assert!(told.contains("--bands needs a single run"), "{told}");
    let told = folder.bad(&["study", "--vary", "key=1,88", "--bands=3"]);
    assert!(told.contains("--bands needs one instrument or one key"), "{told}");
}

mod nightly {
    use super::*;

    /// A sample is the same from an empty cache, from the cache, and from a damaged one; its key in either order.
    #[test]
    #[ignore = "nightly: samples of a key, drawn twice"]
    fn a_cache_changes_no_result() {
        let folder = Folder::new("samples-cache");
        let list = |name: &str| {
            let output = cached(&folder, &["list", name]);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            output.stdout
        };
        let first = list("concert-grand:key=88:sample=2");
        assert_eq!(first, list("concert-grand:sample=2:key=88"));
        let kept: Vec<_> =
            fs::read_dir(folder.0.join("cache/erard")).unwrap().map(|entry| entry.unwrap().path()).collect();
        assert_eq!(kept.len(), 1, "{kept:?}");
        let whole = fs::read(&kept[0]).unwrap();
        fs::write(&kept[0], &whole[..whole.len() / 2]).unwrap();
        assert_eq!(first, list("concert-grand:key=88:sample=2"));
        assert_eq!(whole, fs::read(&kept[0]).unwrap());
    }

    /// Two programs on one cache, and one that is killed as soon as it has begun to write there: every result is that
    /// of the first, and the cache is whole afterwards. What a killed program left is cleared away when it is old.
    #[cfg(unix)]
    #[test]
    #[ignore = "nightly: a sample, drawn ten times"]
    fn two_programs_share_a_cache_and_a_kill_spoils_nothing() {
        use std::process::Stdio;
        use std::time::{Duration, SystemTime};
        let folder = Folder::new("samples-shared-cache");
        let cache = folder.0.join("cache/erard");
        let listing = || {
            let mut command = folder.command(&["list", "concert-grand:sample=8"]);
            command.env("XDG_CACHE_HOME", folder.0.join("cache")).stdout(Stdio::piped()).stderr(Stdio::piped());
            command.spawn().unwrap()
        };
        let kept = || -> Vec<String> {
            let entries = fs::read_dir(&cache).into_iter().flatten();
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
        };
        let told = |child: std::process::Child| {
            let output = child.wait_with_output().unwrap();
            assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
            output.stdout
        };
        let both = [listing(), listing()].map(told);
        assert_eq!(both[0], both[1]);
        assert_eq!(kept().len(), 1, "{:?}", kept());
        let mut killed = 0;
        for _ in 0..3 {
            fs::remove_dir_all(&cache).unwrap();
            let mut child = listing();
            while kept().is_empty() && child.try_wait().unwrap().is_none() {
                std::thread::sleep(Duration::from_micros(20));
            }
            child.kill().unwrap();
            killed += u32::from(!child.wait().unwrap().success());
            assert_eq!(told(listing()), both[0]);
            let whole = kept().iter().filter(|name| !name.ends_with(".part")).count();
            assert_eq!(whole, 1, "{:?}", kept());
        }
        println!("{killed} of 3 were killed");
        // A part that is an hour old goes at the next write, a young one stays: another program may be writing it.
        fs::remove_dir_all(&cache).unwrap();
        fs::create_dir_all(&cache).unwrap();
        for (name, age) in [("sample-0.1.part", 7200), ("sample-0.2.part", 60), ("sample-0", 7200)] {
            fs::write(cache.join(name), "half").unwrap();
            let file = fs::File::options().write(true).open(cache.join(name)).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(age)).unwrap();
        }
        assert_eq!(told(listing()), both[0]);
        let now = kept();
        assert!(!now.contains(&"sample-0.1.part".to_owned()), "{now:?}");
        assert!(["sample-0.2.part", "sample-0"].iter().all(|name| now.contains(&(*name).to_owned())), "{now:?}");
    }

    /// Every command gives its values bands over the same samples, and the same again.
    #[test]
    #[ignore = "nightly: samples of a grand"]
    fn values_have_bands() {
        let folder = Folder::new("samples-bands");
        let rows = |arguments: &[&str], out: &str| -> Vec<Value> {
            let output = cached(&folder, &[arguments, &["--bands=3", "--out", out]].concat());
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let rows: Value = serde_json::from_str(&folder.read(&format!("{out}/bands.json"))).unwrap();
            rows.as_array().unwrap().clone()
        };
        // A force: at a level, each sample pressed alone has a hand of its own, and the band is that of one hand.
        let force = ["press", "--force-step", "5N"];
        let press = rows(&force, "press");
        let speed = press.iter().find(|row| row["name"] == "hammer_speed_m_per_s").unwrap();
        let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
        assert!(number(speed, "low") < number(speed, "high") && speed["samples"] == 3, "{speed}");
        // The band of three is that of the three pressed one by one.
        let mut alone: Vec<f64> = (1..=3)
            .map(|sample| {
                let instrument = format!("concert-grand:sample={sample}");
                let own = ["--instrument", &instrument, "--out", "alone", "--force"];
                let output = cached(&folder, &[&force[..], &own].concat());
                assert!(output.status.success());
                let summary: Value = serde_json::from_str(&folder.read("alone/summary.json")).unwrap();
                number(&summary, "hammer_speed_m_per_s")
            })
            .collect();
        alone.sort_by(f64::total_cmp);
        let low = alone[0] + 0.1 * (alone[1] - alone[0]);
        assert!((number(speed, "low") - low).abs() < 1e-12, "{alone:?} {speed}");
        assert_eq!(press, rows(&force, "again"));

        let measured = rows(&["measure", "--only", "dip_mm,up_weight_g"], "measure");
        assert_eq!(
            measured.iter().map(|row| row["name"].as_str().unwrap()).collect::<Vec<_>>(),
            ["dip_mm", "up_weight_g"]
        );
        assert!(measured.iter().all(|row| number(row, "low") < number(row, "high")), "{measured:?}");

        let study = ["study", "--vary", "force=3,5", "--bands=3", "--out", "study"];
        assert!(cached(&folder, &study).status.success());
        let table = folder.read("study/study.csv");
        let mut reader = csv::Reader::from_reader(table.as_bytes());
        let heads = reader.headers().unwrap().clone();
        let column = |name: &str| heads.iter().position(|head| head == name).unwrap();
        let [value, low, high] =
            ["hammer_speed_m_per_s", "hammer_speed_m_per_s_5", "hammer_speed_m_per_s_95"].map(column);
        let cells: Vec<[f64; 3]> = reader
            .records()
            .map(|row| row.unwrap())
            .map(|row| [value, low, high].map(|at| row[at].parse().unwrap()))
            .collect();
        assert_eq!(cells.len(), 2);
        assert!(cells.iter().all(|[_, low, high]| low < high) && cells[0][2] < cells[1][1], "{cells:?}");
    }

    /// A row of `validate` with its band is met, missed, or cannot be told, and counted so.
    #[test]
    #[ignore = "nightly: validations of samples"]
    fn rows_cannot_always_be_told() {
        let folder = Folder::new("samples-validate");
        let output = cached(&folder, &["validate", "--bands=3", "--out", "out"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let report: Value = serde_json::from_str(&folder.read("out/validate.json")).unwrap();
        let rows = report["rows"].as_array().unwrap();
        let count = |verdict: &str| rows.iter().filter(|row| row["verdict"] == verdict).count() as u64;
        assert_eq!(report["undecided"], count("cannot tell"));
        assert_eq!(report["met"], count("met"));
        assert_eq!(report["missed"], count("missed") + count("did not happen"));
        let judged = |kind: &str| report[kind]["judged"].as_u64().unwrap();
        assert_eq!(judged("predicted") + judged("set"), count("met") + count("missed") + count("did not happen"));
        for row in rows.iter().filter(|row| row["verdict"] == "cannot tell") {
            let [low, high] = ["band_low", "band_high"].map(|key| row[key].as_f64().unwrap());
            if let (Some(least), Some(most)) = (row["at_least"].as_f64(), row["at_most"].as_f64()) {
                assert!(high - low > most - least, "{row}");
            }
            assert!(row["likely_reason"].as_str().unwrap().contains("wider than the published range"), "{row}");
        }
    }
}
