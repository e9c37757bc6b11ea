//! Files with some of their numbers changed.

/// Ranges of the numbers in a TOML text, without comments and words.
pub fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let (mut found, mut offset) = (Vec::new(), 0);
    for line in text.split_inclusive('\n') {
        let (mut quoted, mut begin) = (false, None);
        if !line.trim_start().starts_with('#') && line.contains('=') {
            for (i, c) in line.char_indices() {
                let numeric = c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e');
                match begin {
                    Some(from) if !numeric => {
                        found.push(offset + from..offset + i);
                        begin = None;
                    }
                    None if !quoted && (c.is_ascii_digit() || c == '-') && line[..i].ends_with([' ', '[', '=']) => {
                        begin = Some(i)
                    }
                    _ => {}
                }
                quoted ^= c == '"';
                if c == '#' && !quoted {
                    break;
                }
            }
        }
        offset += line.len();
    }
    found.retain(|range| text[range.clone()].parse::<f64>().is_ok());
    found
}
