//! Notes in a result about what made it: in SVG and PNG, pages and JSON.
//!
//! No time and no place: the same command on the same files gives the same bytes, wherever they are written.

use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

use crate::svg::escape;

/// Provenance of a result.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MadeBy {
    /// Name of the program.
    pub program: String,
    /// Its version.
    pub version: String,
    /// The commit that it was built from, where that was known; a `+` after it: changed since.
    pub commit: Option<String>,
    /// The command that makes the result again, without where it goes.
    pub command: String,
    /// All options, those that were not given too.
    pub options: BTreeMap<String, Vec<String>>,
    /// Inputs, in the order in which they were read.
    pub sources: Vec<Source>,
}

/// Something a result was made from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Source {
    /// `instrument`, `keyboard`, `linkage`, `stroke`, `recording`.
    pub kind: String,
    /// Name.
    pub name: String,
    /// Its file, as it was given; `None` for what is built in.
    pub file: Option<String>,
    /// SHA-256 of its bytes, in hexadecimal digits: that of the file, as `sha256sum` prints it. `None` for what has
    /// none, such as a constant force.
    pub sha256: Option<String>,
    /// What was done to a recording before it was played, channel by channel: zero, resampling, low-pass. Left out for
    /// other sources.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preparation: Option<serde_json::Value>,
}

impl MadeBy {
    /// One line: program, version, commit.
    pub(crate) fn program_line(&self) -> String {
        let commit = self.commit.as_ref().map_or(String::new(), |commit| format!(" ({commit})"));
        format!("{} {}{commit}", self.program, self.version)
    }

    /// Lines for people: the program, the command, the sources.
    pub(crate) fn lines(&self) -> Vec<String> {
        let mut lines = vec![self.program_line(), self.command.clone()];
        for source in &self.sources {
            let file = source.file.as_ref().map_or("built in", String::as_str);
            let digest = source.sha256.as_ref().map_or(String::new(), |digest| format!(", sha256 {digest}"));
            lines.push(format!("{}: {}, {file}{digest}", source.kind, source.name));
        }
        lines
    }

    /// Returns the record as JSON on several lines.
    pub fn json(&self) -> String {
        // Strings and maps of strings: there is nothing that could not be written.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// An SVG document with this in its metadata.
    pub fn in_svg(&self, svg: &str) -> String {
        let Some(at) = svg.find("<svg").and_then(|tag| Some(tag + svg[tag..].find('>')? + 1)) else {
            return svg.into();
        };
        format!("{}<metadata>{}</metadata>{}", &svg[..at], escape(&self.json()), &svg[at..])
    }

    /// A page with this in its head, as data, and at its foot, for people.
    pub fn in_html(&self, html: &str) -> String {
        let mut page = html.to_owned();
        if let Some(at) = page.rfind("</body>") {
            let mut foot = String::from(
                "<footer class=\"made-by\" style=\"margin:2rem 1rem 1rem;font:12px/1.5 system-ui,sans-serif;overflow-wrap:anywhere\">",
            );
            for (n, line) in self.lines().iter().enumerate() {
                let (open, close) = if n == 1 { ("<code>", "</code>") } else { ("", "") };
                // Writing to a string does not fail.
                let _ = write!(foot, "<div>{open}{}{close}</div>", escape(line));
            }
            page.insert_str(at, &(foot + "</footer>\n"));
        }
        if let Some(at) = page.find("</head>") {
            let generator = format!("<meta name=\"generator\" content=\"{}\">\n", escape(&self.program_line()));
            // Within a script nothing is escaped; a `<` is one in JSON too, by its code.
            let data = self.json().replace('<', "\\u003c");
            page.insert_str(
                at,
                &format!("{generator}<script type=\"application/json\" id=\"made-by\">{data}</script>\n"),
            );
        }
        page
    }

    /// A JSON text whose outermost object, or the first in its outermost list, begins with this as `made_by`.
    pub fn in_json(&self, json: &str) -> String {
        let begin = json.len() - json.trim_start().len();
        let depth = if json[begin..].starts_with('[') { 2 } else { 1 };
        let Some(at) = json.find('{').filter(|at| json[begin..*at].chars().all(|c| c == '[' || c.is_whitespace()))
        else {
            return json.into();
        };
        let indent = "  ".repeat(depth);
        let own = self.json().replace('\n', &format!("\n{indent}"));
        let rest = &json[at + 1..];
        let comma = if rest.trim_start().starts_with('}') { "\n" } else { "," };
        format!("{}\n{indent}\"made_by\": {own}{comma}{rest}", &json[..=at])
    }

    /// A PNG with this as text: `Software`, and `Comment` in JSON.
    #[cfg(feature = "png")]
    pub fn in_png(&self, png: &[u8]) -> Vec<u8> {
        // The signature and the header, which comes first and is 13 bytes long.
        const HEAD: usize = 8 + 12 + 13;
        if png.len() < HEAD {
            return png.to_vec();
        }
        let (head, rest) = png.split_at(HEAD);
        [head, &text_chunk("Software", &self.program_line()), &text_chunk("Comment", &self.json()), rest].concat()
    }
}

/// An `iTXt` chunk: a keyword and a text in UTF-8, not compressed, in no language.
#[cfg(feature = "png")]
fn text_chunk(keyword: &str, text: &str) -> Vec<u8> {
    let data = [b"iTXt", keyword.as_bytes(), &[0, 0, 0, 0, 0], text.as_bytes()].concat();
    let length = u32::try_from(data.len() - 4).unwrap_or(0);
    [&length.to_be_bytes()[..], &data, &crc32fast::hash(&data).to_be_bytes()].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made_by() -> MadeBy {
        MadeBy {
            program: "erard".into(),
            version: "0.1.0".into(),
            commit: Some("0123abc".into()),
            command: "erard press --stroke 'a<b & \"c\"'".into(),
            options: BTreeMap::from([("stroke".to_owned(), vec!["</script>".to_owned()])]),
            sources: vec![Source {
                kind: "stroke".into(),
                name: "é".into(),
                file: None,
                sha256: Some("00".into()),
                preparation: None,
            }],
        }
    }

    #[test]
    fn json_goes_on_being_what_it_was() {
        let own = serde_json::to_value(made_by()).unwrap();
        for (text, at) in [
            ("{\n  \"a\": [1.5e-7, null]\n}\n", "/a/0"),
            ("{}", ""),
            ("[\n  {\n    \"a\": 2\n  },\n  {\n    \"a\": 3\n  }\n]", "/1/a"),
        ] {
            let before: serde_json::Value = serde_json::from_str(text).unwrap();
            let after: serde_json::Value = serde_json::from_str(&made_by().in_json(text)).unwrap();
            let holder = if text.starts_with('[') { &after[0] } else { &after };
            assert_eq!(holder["made_by"], own, "{text}");
            assert_eq!(before.pointer(at).filter(|v| !v.is_object()), after.pointer(at).filter(|v| !v.is_object()));
        }
        assert_eq!(made_by().in_json("[1, 2]"), "[1, 2]");
    }

    #[test]
    fn pages_and_figures_stay_well_formed() {
        let svg = made_by().in_svg("<?xml version=\"1.0\"?><svg width=\"1\" height=\"2\"><g/></svg>");
        assert!(svg.contains("height=\"2\"><metadata>{") && svg.ends_with("</metadata><g/></svg>"), "{svg}");
        assert!(!svg.contains("a<b") && !svg.contains("</script>"), "{svg}");
        let html = made_by().in_html("<html><head><title>x</title></head><body><p>y</p></body></html>");
        assert_eq!(html.matches("</script>").count(), 1, "{html}");
        assert!(html.contains("a&lt;b") && html.contains("erard 0.1.0 (0123abc)"), "{html}");
        assert_eq!(made_by().in_svg("no picture"), "no picture");
    }

    /// The decoder, which checks the chunks' sums, reads the picture as before, and the text stands in it.
    #[cfg(feature = "png")]
    #[test]
    fn a_png_is_read_as_before() {
        let figure = crate::figure::Figure::over("x", (0.0, 1.0), "t".into(), String::new(), Vec::new());
        let plain = crate::figure::figure_picture(&figure).png(0.5).unwrap();
        let stamped = made_by().in_png(&plain);
        let pixels = |png: &[u8]| {
            let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            pixels
        };
        assert_eq!(pixels(&plain), pixels(&stamped));
        let text = String::from_utf8_lossy(&stamped).into_owned();
        assert!(text.contains("iTXtSoftware\0\0\0\0\0erard 0.1.0 (0123abc)") && text.contains("iTXtComment"), "{text}");
        // A known sum (RFC 2083 gives the one of an empty IEND).
        assert_eq!(crc32fast::hash(b"IEND"), 0xAE42_6082);
    }
}
