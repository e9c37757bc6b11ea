//! A chapter's code blocks and what is to be done with them.

/// A fenced block.
#[derive(Debug)]
pub struct Block {
    /// Line of the opening fence, from 1.
    pub line: usize,
    /// Its content, with line ends.
    pub text: String,
    /// Kind of the block.
    pub kind: Kind,
}

/// The kind of a block, by its info string.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// `sh`: commands that succeed.
    Run,
    /// `sh,fails`: commands of which the last ends with code 2.
    Fails,
    /// `sh,no_run`: commands for the reader only.
    NoRun,
    /// `text,output`: all that the last command printed, but for numbers.
    Output,
    /// `text`, `math`: sketches and equations.
    Text,
    /// `toml`, `csv`, `json`: an excerpt that must parse.
    Excerpt(Format),
    /// `toml,file=NAME`: a whole file, from here on in the folder.
    File(String),
    /// `toml,find=NAME`: what stands once in a file of the folder.
    Find(String),
    /// `toml,replace=NAME`: what the reader puts where the last `find` was.
    Replace(String),
    /// No fence but a comment, `<!-- holds: A < B -->`: a claim of the text beside it, about numbers that commands
    /// wrote.
    Claim,
}

/// A format of data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Format {
    Toml,
    Csv,
    Json,
}

const FENCE: &str = "```";

/// All fenced blocks of a chapter. Indented or tilde fences are refused, so that none is passed over.
pub fn read(text: &str) -> Result<Vec<Block>, String> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut open = false;
    for (i, line) in text.lines().enumerate() {
        let number = i + 1;
        if line.trim_start().starts_with("~~~") || (line.trim_start().starts_with(FENCE) && !line.starts_with(FENCE)) {
            return Err(format!("{number}: a fence starts its line, with backticks"));
        }
        match (line.strip_prefix(FENCE), open) {
            (Some(info), false) => {
                let kind = kind(info).map_err(|fault| format!("{number}: {fault}"))?;
                blocks.push(Block { line: number, text: String::new(), kind });
                open = true;
            }
            (Some(_), true) => open = false,
            (None, true) => {
                let block = &mut blocks.last_mut().expect("one is open").text;
                block.push_str(line);
                block.push('\n');
            }
            (None, false) => {
                if let Some(claim) = line.strip_prefix("<!-- holds:") {
                    let claim = claim.strip_suffix("-->").ok_or(format!("{number}: a claim ends on its line"))?;
                    blocks.push(Block { line: number, text: claim.trim().into(), kind: Kind::Claim });
                }
            }
        }
    }
    if open { Err("a fence is not closed".into()) } else { Ok(blocks) }
}

fn kind(info: &str) -> Result<Kind, String> {
    let unknown = || format!("`{info}` is no kind of block that the tests know");
    let (language, mark) = info.split_once(',').unwrap_or((info, ""));
    let data = match language {
        "toml" => Some(Format::Toml),
        "csv" => Some(Format::Csv),
        "json" => Some(Format::Json),
        _ => None,
    };
    Ok(match (language, data, mark.split_once('=')) {
        ("sh", _, None) if mark.is_empty() => Kind::Run,
        ("sh", _, None) if mark == "fails" => Kind::Fails,
        ("sh", _, None) if mark == "no_run" => Kind::NoRun,
        ("text" | "math", _, None) if mark.is_empty() => Kind::Text,
        ("text", _, None) if mark == "output" => Kind::Output,
        (_, Some(format), None) if mark.is_empty() => Kind::Excerpt(format),
        (_, Some(_), Some(("file", name))) => Kind::File(name.into()),
        (_, Some(_), Some(("find", name))) => Kind::Find(name.into()),
        (_, Some(_), Some(("replace", name))) => Kind::Replace(name.into()),
        _ => return Err(unknown()),
    })
}

/// The chapter with new text in its output blocks.
pub fn with_outputs(text: &str, printed: &[(&Block, String)]) -> String {
    let mut out = String::new();
    let mut skipping = false;
    for (i, line) in text.lines().enumerate() {
        if skipping && line.starts_with(FENCE) {
            skipping = false;
        }
        if !skipping {
            out.push_str(line);
            out.push('\n');
        }
        if let Some((_, output)) = printed.iter().find(|(block, _)| block.line == i + 1) {
            out.push_str(output);
            skipping = true;
        }
    }
    out
}

/// Words and signs of a line, every number as `#`: what must agree although a parameter has changed by a little.
pub fn without_numbers(line: &str) -> String {
    let is_number = |word: &str| {
        let word = word.trim_matches(['(', ')', ',', ';', '%']);
        word.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '−')
            && word.contains(|c: char| c.is_ascii_digit())
    };
    line.split_whitespace().map(|word| if is_number(word) { "#" } else { word }).collect::<Vec<_>>().join(" ")
}

#[test]
fn blocks_have_kinds() {
    let blocks = read("a\n```sh\nerard\n```\n```toml,file=a.toml\nx = 1\n```\n").expect("good");
    assert_eq!(blocks.iter().map(|b| b.line).collect::<Vec<_>>(), [2, 5]);
    assert_eq!(blocks[0].kind, Kind::Run);
    assert_eq!((&blocks[1].kind, &*blocks[1].text), (&Kind::File("a.toml".into()), "x = 1\n"));
    for wrong in ["```rust\n```", "```\n```", "```sh,maybe\n```", "```sh\n", " ```sh\n ```", "~~~\n~~~"] {
        assert!(read(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn numbers_may_differ_and_words_may_not() {
    assert_eq!(without_numbers("  let-off   51.07 ms (3.2 %)"), without_numbers("let-off 9 ms (44.0 %)"));
    assert_ne!(without_numbers("let-off 51 ms"), without_numbers("let-off -"));
    assert_ne!(without_numbers("let-off 51 ms"), without_numbers("check 51 ms"));
}

#[test]
fn outputs_are_replaced_and_nothing_else() {
    let page = "a\n```text,output\nold\nolder\n```\nb\n```text\nkept\n```\n";
    let blocks = read(page).expect("good");
    let new = with_outputs(page, &[(&blocks[0], "new\n".into())]);
    assert_eq!(new, "a\n```text,output\nnew\n```\nb\n```text\nkept\n```\n");
}
