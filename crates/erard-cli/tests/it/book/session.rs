//! What a reader does who follows a chapter: files written, commands run, in a folder that looks like the project's.

use std::env::consts::EXE_SUFFIX;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use super::blocks::{Block, Format, Kind, without_numbers};
use crate::common::Folder;
use crate::generated;

/// A chapter being followed.
pub struct Session {
    folder: Folder,
    /// What the last command printed.
    printed: Option<String>,
    /// The file and text that the last `find` found.
    found: Option<(String, String)>,
}

impl Session {
    /// An empty folder but for the project's data files.
    pub fn new(page: &str) -> Self {
        let folder = Folder::new(&format!("book-{}", page.replace(['/', '.'], "-")));
        let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        for home in [
            "erard-core/instruments",
            "erard-core/keyboards",
            "erard-kinematics/linkages",
            "erard-core/strokes",
            "erard-core/recordings",
            "erard-piece/pieces",
        ] {
            let data = Path::new(home).file_name().unwrap();
            fs::create_dir(folder.0.join(data)).unwrap();
            for entry in fs::read_dir(crates.join(home)).unwrap() {
                let from = entry.unwrap().path();
                fs::copy(&from, folder.0.join(data).join(from.file_name().unwrap())).unwrap();
            }
        }
        Session { folder, printed: None, found: None }
    }

    /// Does what a block asks for. For an output block: what it should hold.
    pub fn play(&mut self, block: &Block) -> Result<Option<String>, String> {
        let text = &block.text;
        match &block.kind {
            Kind::Run => self.run(text, 0)?,
            Kind::Fails => self.run(text, 2)?,
            Kind::NoRun | Kind::Text => {}
            Kind::Excerpt(format) => parse(*format, text)?,
            Kind::File(name) => self.folder.file(name, text),
            // The middle of a line may be meant.
            Kind::Find(name) => self.find(name, text.trim_end_matches('\n'))?,
            Kind::Replace(name) => self.replace(name, text.trim_end_matches('\n'))?,
            Kind::Claim => self.claim(text)?,
            Kind::Output => return self.output(text).map(Some),
        }
        Ok(None)
    }

    /// Runs commands, a line each; the last one ends with this code, the others with 0.
    fn run(&mut self, text: &str, code: i32) -> Result<(), String> {
        let text = text.replace("\\\n", " ");
        let lines: Vec<&str> = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#')).collect();
        for (i, line) in lines.iter().enumerate() {
            let expected = if i + 1 == lines.len() { code } else { 0 };
            self.command(line, expected).map_err(|fault| format!("`{line}`: {fault}"))?;
        }
        Ok(())
    }

    fn command(&mut self, line: &str, expected: i32) -> Result<(), String> {
        let words = words(line)?;
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let erard = Path::new(env!("CARGO_BIN_EXE_erard"));
        let (program, arguments) = match words[..] {
            ["erard", ref arguments @ ..] | ["cargo", "run", "--release", "--", ref arguments @ ..] => {
                (erard.to_owned(), arguments)
            }
            // A program of another package, built beside this one.
            [program @ ("erard-reproduce" | "erard-bench"), ref arguments @ ..] => {
                (erard.with_file_name(format!("{program}{EXE_SUFFIX}")), arguments)
            }
            ["cp", from, to] => {
                let path = |name| self.folder.0.join(name);
                return fs::copy(path(from), path(to)).map(|_| ()).map_err(|e| e.to_string());
            }
            _ => {
                return Err(
                    "only `erard`, programs of `papers/`, `cargo run --release --` and `cp` are run; mark the block no_run"
                        .into(),
                );
            }
        };
        let failed = |error| format!("{}: {error}; `cargo build --release --workspace` builds it", program.display());
        let began = Instant::now();
        let output = Command::new(&program).current_dir(&self.folder.0).args(arguments).output().map_err(failed)?;
        println!("{:6.1} s  {line}", began.elapsed().as_secs_f64());
        let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        if output.status.code() != Some(expected) {
            return Err(format!("ended with {}, expected {expected}: {err}", output.status));
        }
        // What went wrong is said on stderr, all else on stdout.
        self.printed = Some(if expected == 0 { out.into_owned() } else { err.into_owned() });
        Ok(())
    }

    /// Holds an output block against what was printed; gives what was printed.
    fn output(&self, text: &str) -> Result<String, String> {
        let printed = self.printed.as_ref().ok_or("an output stands before the first command")?;
        // How long it took, and with how much memory, depends on the machine. The command to repeat stands above, and
        // the version and the digest beside it change.
        let untimed = |line: &'_ str| match line.find(" simulations, ") {
            Some(at) => format!("{} simulations", &line[..at]),
            None => line.to_owned(),
        };
        let of_machine = |l: &str| l.contains("real-time factor") || l.starts_with("peak memory ");
        let mut repeats = false;
        let lines = printed.lines().filter(|line| {
            repeats |= line.starts_with("Repeat:  ");
            let is_left_out = repeats || of_machine(line);
            repeats &= !line.contains("  (erard ");
            !is_left_out
        });
        let printed = lines.map(untimed).collect::<Vec<_>>().join("\n").trim_end().to_owned() + "\n";
        let writing = generated::rewritten_below().is_some();
        let plain = |text: &str| text.lines().map(without_numbers).collect::<Vec<_>>();
        if writing || plain(text) == plain(&printed) {
            return Ok(printed);
        }
        Err(format!("this output is not what is printed now (beside numbers):\n{printed}"))
    }

    fn find(&mut self, name: &str, text: &str) -> Result<(), String> {
        let times = self.folder.read(name).matches(text).count();
        if times != 1 {
            return Err(format!("{name} holds this {times} times, not once"));
        }
        self.found = Some((name.into(), text.into()));
        Ok(())
    }

    fn replace(&mut self, name: &str, text: &str) -> Result<(), String> {
        let (file, found) = self.found.take().ok_or("nothing was found before")?;
        if file != name {
            return Err(format!("what was found stands in {file}"));
        }
        let whole = self.folder.read(name);
        self.folder.file(name, &whole.replacen(&found, text, 1));
        Ok(())
    }

    /// Holds a claim: `A < B`, `A > B`, `A = B`, `A != B`, or `A ~ B` (to a millionth). A and B are numbers, places in
    /// JSON files (`run/summary.json#/steps`) or in tables (`run/run.csv#key_m@0.5`: the column's first row from 0.5 s
    /// on).
    fn claim(&self, text: &str) -> Result<(), String> {
        let [a, sign, b] = text.split_whitespace().collect::<Vec<_>>()[..] else {
            return Err(format!("`{text}` is no claim"));
        };
        let (x, y) = (self.value(a)?, self.value(b)?);
        let holds = match sign {
            "<" => x < y,
            ">" => x > y,
            "=" => x == y,
            "!=" => x != y,
            "~" => (x - y).abs() <= 1e-6 * x.abs().max(y.abs()),
            _ => return Err(format!("`{sign}` is no comparison")),
        };
        if holds { Ok(()) } else { Err(format!("the text claims {text}, but these are {x} and {y}")) }
    }

    fn value(&self, name: &str) -> Result<f64, String> {
        let Some((file, place)) = name.split_once('#') else {
            return name.parse().map_err(|_| format!("`{name}` is neither a number nor a place in a file"));
        };
        let missing = || format!("{name} is no number");
        let text = self.folder.read(file);
        if let Some((column, time)) = place.split_once('@') {
            let time: f64 = time.parse().map_err(|_| missing())?;
            let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
            let index = lines.next().and_then(|header| header.iter().position(|c| *c == column)).ok_or_else(missing)?;
            let row = lines.find(|row| row[0].parse().is_ok_and(|t: f64| t >= time)).ok_or_else(missing)?;
            return row[index].parse().map_err(|_| missing());
        }
        let json: serde_json::Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
        let value = json.pointer(place).ok_or_else(missing)?;
        // True is 1.
        value.as_f64().or(value.as_bool().map(|b| f64::from(u8::from(b)))).ok_or_else(missing)
    }

    /// Takes a picture that the commands have drawn below the page's home: `pictures/X/Y` is the folder's `X/Y`.
    pub fn keep(&self, picture: &str, source: &Path) -> Result<(), String> {
        let (drawn, kept) = self.paths(picture, source)?;
        fs::create_dir_all(kept.parent().expect("below its home")).map_err(|e| e.to_string())?;
        fs::copy(drawn, kept).map(|_| ()).map_err(|e| e.to_string())
    }

    /// Whether a picture was drawn by the commands and still has the same words: an instrument may have changed a
    /// little since, the program not.
    pub fn compare(&self, picture: &str, source: &Path) -> Result<(), String> {
        let (drawn, kept) = self.paths(picture, source)?;
        let read = |path: &Path| fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()));
        if captions(&read(&drawn)?) == captions(&read(&kept)?) {
            return Ok(());
        }
        Err(format!("{picture} is not what its command draws now"))
    }

    fn paths(&self, picture: &str, source: &Path) -> Result<(std::path::PathBuf, std::path::PathBuf), String> {
        let drawn = picture.strip_prefix("pictures/").map(|p| self.folder.0.join(p));
        match drawn {
            Some(drawn) if drawn.is_file() => Ok((drawn, source.join(picture))),
            _ => Err(format!("{picture}: no command of the page draws it")),
        }
    }
}

/// The words in an SVG, sorted, without those that hold numbers.
fn captions(svg: &str) -> Vec<&str> {
    let mut words: Vec<&str> = svg
        .split('>')
        .filter_map(|piece| {
            piece.split_once('<').filter(|(_, tag)| tag.starts_with("/text") || tag.starts_with("/tspan"))
        })
        .flat_map(|(text, _)| text.split_whitespace())
        .filter(|word| word.chars().all(|c| c.is_alphabetic() || "-,".contains(c)) && *word != "N")
        .collect();
    words.sort_unstable();
    words
}

fn parse(format: Format, text: &str) -> Result<(), String> {
    match format {
        Format::Toml => toml::from_str::<toml::Table>(text).map(|_| ()).map_err(|e| e.to_string()),
        Format::Json => serde_json::from_str::<serde_json::Value>(text).map(|_| ()).map_err(|e| e.to_string()),
        Format::Csv => {
            let mut reader = csv::Reader::from_reader(text.as_bytes());
            reader.records().try_for_each(|row| row.map(|_| ()).map_err(|e| e.to_string()))
        }
    }
}

/// Splits a line at blanks, except in double or single quotes.
fn words(line: &str) -> Result<Vec<String>, String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in line.chars() {
        match (c, quote) {
            (c, Some(q)) if c == q => quote = None,
            (c, Some(_)) => word.get_or_insert_default().push(c),
            ('"' | '\'', None) => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            ('#', None) if word.is_none() => break,
            ('|' | '>' | '<' | '&' | ';' | '$' | '*' | '`', None) => return Err(format!("no shell is run: `{c}`")),
            (c, None) if c.is_whitespace() => words.extend(word.take()),
            (c, None) => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    if quote.is_some() { Err("a quote is not closed".into()) } else { Ok(words) }
}

#[test]
fn what_is_not_so_is_found() {
    let mut session = Session::new("not so");
    session.folder.file("a.csv", "time_s,x\n0,1\n1,2\n");
    session.folder.file("a.json", "{ \"b\": [3, null] }");
    for (claim, holds) in [
        ("a.csv#x@1 = 2", true),
        ("a.csv#x@0.5 > a.csv#x@0", true),
        ("a.json#/b/0 ~ 3.0000001", true),
        ("a.csv#x@1 = 1", false),
        ("a.csv#y@1 = 1", false),
        ("a.csv#x@2 > 0", false),
        ("a.json#/b/0 < 3", false),
        ("a.json#/b/1 != 0", false),
    ] {
        assert_eq!(session.claim(claim).is_ok(), holds, "{claim}");
    }
    // It is no stroke: neither force nor position.
    assert!(session.run("erard check a.csv", 0).is_err());
    assert!(session.run("erard check a.csv", 2).is_ok());
    assert!(session.output("something else\n").is_err());
    for line in ["ls", "erard check a.csv | head", "cp 'a.csv b.csv"] {
        assert!(session.run(line, 0).is_err(), "{line}");
    }
    assert!(session.find("a.csv", "1").is_err(), "there are two");
    assert!(session.find("a.csv", "x\n0").is_ok() && session.replace("a.csv", "y\n0").is_ok());
    assert_eq!(session.folder.read("a.csv"), "time_s,y\n0,1\n1,2\n");
}
