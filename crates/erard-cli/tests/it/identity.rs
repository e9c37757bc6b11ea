//! Every result names what made it, and is the same wherever it is written.

use std::fs;

use crate::common::Folder;
use parquet::basic::{Compression, Type};
use parquet::file::reader::{FileReader, SerializedFileReader};
use serde_json::Value;

/// The citation that a command gives is that of `CITATION.cff`, for the command and what it read; every command has it.
#[test]
fn every_answer_can_be_cited() {
    let folder = Folder::new("identity-cited");
    fs::write(folder.0.join("a_b.csv"), "time_s,force_N\n0,0\n1,5\n").unwrap();
    let command = ["press", "a_b.csv", "--duration", "0.005"];
    let plain = folder.short(&command);
    let cited = folder.short(&[&command[..], &["--bibtex"]].concat());
    let entry = cited.strip_prefix(&plain).expect("the entry comes last");
    let citation = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../CITATION.cff")).unwrap();
    let said =
        |key: &str| citation.lines().find_map(|line| line.trim_start_matches(['-', ' ']).strip_prefix(key)).unwrap();
    assert!(entry.starts_with("@software{erard,\n") && entry.ends_with("\n}\n"), "{entry}");
    assert!(entry.contains(&format!("  title   = {{{}}},", said("title: ").trim_matches('"'))), "{entry}");
    assert!(entry.contains(&format!("  author  = {{{{{}}}}},", said("name: "))), "{entry}");
    assert!(entry.contains(&format!("  version = {{{}}},", said("version: "))), "{entry}");
    // As LaTeX prints it.
    assert!(entry.contains("\\texttt{erard press a\\_b.csv -{}-{}duration 0.005}"), "{entry}");
    let digest = plain.split("digest ").nth(1).unwrap().split(')').next().unwrap();
    assert!(entry.contains(&format!(", digest {digest}}}")), "{entry}");
    let count = |sign: char| entry.matches(sign).count() - entry.matches(&format!("\\{sign}")).count();
    assert_eq!(count('{'), count('}'), "{entry}");
    // The files are the same; the answer as JSON has the entry only where it is asked for.
    let json = |more: &[&str]| {
        serde_json::from_str::<Value>(&folder.short(&[&command[..], &["--json"], more].concat())).unwrap()
    };
    let [without, mut with] = [json(&[]), json(&["--bibtex"])];
    let own = with.as_object_mut().unwrap().remove("bibtex").unwrap();
    assert_eq!((own.as_str().unwrap(), &with), (entry.trim_end(), &without));
    assert!(folder.short(&["list", "strokes", "--bibtex"]).contains("@software{erard,"));
}

/// What the coreutils say the digest of a file is: not this program's own code.
#[cfg(target_os = "linux")]
fn sha256sum(folder: &Folder, file: &str) -> String {
    let output = std::process::Command::new("sha256sum").arg(folder.0.join(file)).output().unwrap();
    String::from_utf8(output.stdout).unwrap().split_whitespace().next().unwrap().to_owned()
}

fn json(folder: &Folder, name: &str) -> Value {
    serde_json::from_str(&folder.read(name)).unwrap()
}

/// The text chunks of a PNG: keyword and text.
fn texts(png: &[u8]) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut at = 8;
    while at + 12 <= png.len() {
        let length = u32::from_be_bytes(png[at..at + 4].try_into().unwrap()) as usize;
        let data = &png[at + 8..at + 8 + length];
        if &png[at + 4..at + 8] == b"iTXt" {
            let end = data.iter().position(|byte| *byte == 0).unwrap();
            let text = String::from_utf8(data[end + 5..].to_vec()).unwrap();
            found.push((String::from_utf8(data[..end].to_vec()).unwrap(), text));
        }
        at += 12 + length;
    }
    found
}

/// The metadata of an SVG, unescaped.
fn metadata(svg: &str) -> Value {
    let text = svg.split_once("<metadata>").unwrap().1.split_once("</metadata>").unwrap().0;
    let text = text.replace("&quot;", "\"").replace("&#39;", "'").replace("&lt;", "<").replace("&gt;", ">");
    serde_json::from_str(&text.replace("&amp;", "&")).unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_names_what_made_it() {
    let folder = Folder::new("identity-run");
    folder.file("mine.toml", include_str!("../../../erard-core/instruments/concert-grand.toml"));
    folder.file("a stroke.csv", "time_s,force_N\n0,0\n0.03,5\n0.2,5\n");
    let arguments =
        ["press", "a stroke.csv", "--instrument", "mine.toml", "--duration", "0.1", "--out", "somewhere", "--force"];
    folder.good(&arguments);
    let made_by = json(&folder, "somewhere/summary.json")["made_by"].clone();
    assert_eq!(made_by["program"], "erard");
    assert_eq!(made_by["version"], env!("CARGO_PKG_VERSION"));
    assert!(made_by["commit"].is_null() || made_by["commit"].as_str().unwrap().len() >= 12, "{made_by}");
    assert_eq!(made_by["command"], "erard press 'a stroke.csv' --instrument mine.toml --duration 0.1");
    // Options that were not given stand there too.
    assert_eq!(made_by["options"]["dt"], serde_json::json!(["usual"]));
    assert!(made_by["options"].get("out").is_none() && made_by["options"].get("force").is_none(), "{made_by}");
    let sources = made_by["sources"].as_array().unwrap();
    for (kind, name, file) in
        [("instrument", "Concert grand, C4", "mine.toml"), ("recording", "a stroke.csv", "a stroke.csv")]
    {
        let source = sources.iter().find(|source| source["kind"] == kind).unwrap();
        assert_eq!((source["name"].as_str(), source["file"].as_str()), (Some(name), Some(file)));
        assert_eq!(source["sha256"].as_str().unwrap(), sha256sum(&folder, file), "{file}");
    }
    // The same in every result that can hold it, and nothing of where or when.
    assert_eq!(metadata(&folder.read("somewhere/run.svg")), made_by);
    let png = texts(&fs::read(folder.0.join("somewhere/run.png")).unwrap());
    assert!(png[0].0 == "Software" && png[0].1.starts_with("erard "), "{png:?}");
    assert_eq!(serde_json::from_str::<Value>(&png[1].1).unwrap(), made_by);
    let page = folder.read("somewhere/run.html");
    let data = page.split_once("id=\"made-by\">").unwrap().1.split_once("</script>").unwrap().0;
    assert_eq!(serde_json::from_str::<Value>(data).unwrap(), made_by);
    assert!(page.contains("<meta name=\"generator\" content=\"erard ") && page.contains("<footer class=\"made-by\""));
    let file = fs::File::open(folder.0.join("somewhere/run.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let kept = reader.metadata().file_metadata().key_value_metadata().unwrap();
    let of = |key: &str| -> Value {
        serde_json::from_str(kept.iter().find(|pair| pair.key == key).unwrap().value.as_ref().unwrap()).unwrap()
    };
    assert_eq!(of("made_by"), made_by);
    for (column, unit) in
        [("time_s", "s"), ("force_N", "N"), ("key_m", "m"), ("key_rad", "rad"), ("hammer_rad_per_s", "rad/s")]
    {
        assert_eq!(of("units")[column], unit, "{column}");
    }
    let group = reader.metadata().row_group(0);
    assert!(group.columns().iter().all(|column| column.compression() == Compression::SNAPPY));
    for name in ["summary.json", "run.svg", "run.html"] {
        assert!(!folder.read(&format!("somewhere/{name}")).contains("somewhere"), "{name}");
    }
}

/// The command that a result names makes it again, wherever: the same bytes.
#[test]
fn the_command_makes_it_again() {
    let folder = Folder::new("identity-again");
    folder.good(&["press", "--stroke", "p", "--touch", "struck", "--duration", "0.1", "--out", "first/run"]);
    let command = json(&folder, "first/run/summary.json")["made_by"]["command"].as_str().unwrap().to_owned();
    let words: Vec<&str> = command.split(' ').skip(1).collect();
    folder.good(&words);
    folder.good(&[&words[..], &["--out=again", "--quiet"]].concat());
    let bytes = |name: &str| fs::read(folder.0.join(name)).unwrap();
    for name in ["run.svg", "run.png", "run.csv", "run.parquet"] {
        let first = bytes(&format!("first/run/{name}"));
        assert!(first == bytes(&format!("erard-out/{name}")) && first == bytes(&format!("again/{name}")), "{name}");
    }
}

/// Each command's results: the built-in grand and its digest are named.
#[cfg(target_os = "linux")]
#[test]
fn every_command_s_results() {
    let folder = Folder::new("identity-all");
    folder.file("concert-grand.toml", include_str!("../../../erard-core/instruments/concert-grand.toml"));
    let grand = sha256sum(&folder, "concert-grand.toml");
    folder.good(&["press", "--duration", "0.05", "--out", "run"]);
    for (arguments, files) in [
        (&["draw", "--at", "20"][..], &["erard-out-draw/action.svg", "erard-out-draw/action.png"][..]),
        (&["study", "--vary", "let_off=-0.2..0.2:2", "--duration", "0.1"], &["erard-out-study/study.svg"]),
        (&["compare", "run/run.csv"], &["erard-out-compare/compare.json", "erard-out-compare/compare.png"]),
    ] {
        folder.good(arguments);
        for file in files {
            let text = String::from_utf8_lossy(&fs::read(folder.0.join(file)).unwrap()).replace("&quot;", "\"");
            assert!(text.contains(&grand) && text.contains(&format!("erard {}", arguments[0])), "{file}");
            assert!(text.contains("\"program\": \"erard\"") && text.contains("Concert grand"), "{file}");
        }
    }
}

/// A CSV's bytes are its table and nothing else; what made it, and its columns' units, lie beside it.
#[cfg(target_os = "linux")]
#[test]
fn tables_have_their_metadata_beside_them() {
    metadata_beside(&[
        (&["press", "--duration", "0.05", "--reactions"], "run.csv"),
        (&["study", "--vary", "let_off=-0.2..0.2:2", "--duration", "0.1"], "study.csv"),
        (&["press", "--duration", "0.05", "--against", "f"], "run-2.csv"),
    ]);
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "ci: two keyboards, and a comparison"]
fn keyboards_and_comparisons_have_their_metadata_beside_them() {
    metadata_beside(&[
        (&["compare", "run/run.csv", "--no-pictures"], "compare.csv"),
        (&["keyboard", "--every", "87"], "keyboard.csv"),
        (&["keyboard", "concert-grand", "concert-grand", "--every", "87"], "difference.csv"),
        (&["press", "--duration", "0.05", "--against", "f"], "run-2.csv"),
    ]);
}

/// Commands and a table of each; the last leaves `run-2.csv`.
#[cfg(target_os = "linux")]
fn metadata_beside(commands: &[(&[&str], &str)]) {
    let folder = Folder::new("identity-tables");
    folder.good(&["press", "--duration", "0.05", "--reactions", "--out", "run"]);
    for &(arguments, table) in commands {
        folder.good(&[arguments, &["--out", "out", "--force"]].concat());
        let metadata = json(&folder, &format!("out/{table}-metadata.json"));
        assert_eq!((&metadata["@context"], &metadata["url"]), (&"http://www.w3.org/ns/csvw".into(), &table.into()));
        assert!(metadata["made_by"]["command"].as_str().unwrap().starts_with(&format!("erard {}", arguments[0])));
        assert!(metadata["made_by"]["sources"].as_array().unwrap().iter().all(|source| source["sha256"].is_string()));
        let text = folder.read(&format!("out/{table}"));
        let columns = metadata["tableSchema"]["columns"].as_array().unwrap();
        let titles: Vec<&str> = columns.iter().map(|column| column["titles"].as_str().unwrap()).collect();
        assert_eq!(text.lines().next().unwrap().split(',').collect::<Vec<_>>(), titles, "{table}");
    }
    let metadata = json(&folder, "run/run.csv-metadata.json");
    let unit = |title: &str| {
        let columns = metadata["tableSchema"]["columns"].as_array().unwrap();
        columns.iter().find(|column| column["titles"] == title).unwrap()["schema:unitText"].clone()
    };
    for (title, wanted) in [("time_s", "s"), ("key_m", "m"), ("hammer_rad_per_s2", "rad/s2"), ("key_pin_x_N", "N")] {
        assert_eq!(unit(title), wanted, "{title}");
    }
    // A table that is no longer made takes its metadata along, and what lies beside it is a result like any other.
    folder.good(&["press", "--duration", "0.05", "--out", "out", "--force"]);
    assert!(
        !folder.0.join("out/run-2.csv-metadata.json").exists() && folder.0.join("out/run.csv-metadata.json").exists()
    );
    fs::create_dir(folder.0.join("theirs")).unwrap();
    folder.file("theirs/run.csv-metadata.json", "{}");
    assert!(folder.bad(&["press", "--out", "theirs"]).contains("run.csv-metadata.json"));
    assert!(folder.good(&["check", "run/run.csv-metadata.json"]).contains("erard press --duration 0.05"));
}

/// What is counted is whole.
#[test]
fn counts_are_integers() {
    let folder = Folder::new("identity-counts");
    folder.good(&["study", "--vary", "force=2,5", "--duration", "0.2"]);
    let file = fs::File::open(folder.0.join("erard-out-study/study.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let schema = reader.metadata().file_metadata().schema_descr();
    let kind = |name: &str| schema.columns().iter().find(|column| column.name() == name).unwrap().physical_type();
    for (name, wanted) in [
        ("impact_count", Type::INT32),
        ("failed", Type::INT32),
        ("unconverged_steps", Type::INT32),
        ("check_s", Type::DOUBLE),
    ] {
        assert_eq!(kind(name), wanted, "{name}");
    }
    assert!(folder.read("erard-out-study/study.csv").lines().nth(1).unwrap().contains(",1,"));
}
