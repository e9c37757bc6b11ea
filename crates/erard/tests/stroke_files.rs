//! Stroke files: what reads, and the one message that each thing gives that does not.

use std::io::Read;
use std::path::Path;
use std::time::{Duration, Instant};

use erard::stroke::{Cursor, MAX_ROWS, Series, StrokeError};

fn error_of(text: &str) -> Box<StrokeError> {
    match Series::parse(text, "stroke.csv") {
        Ok(_) => panic!("this should not read:\n{text}"),
        Err(error) => error,
    }
}

#[test]
fn force_position_or_both_with_other_columns_beside_them() {
    let both = Series::parse("time_s,force_N,position_m\n0,0,0\n0.01,2,0.001\n0.05,5,0.009\n", "").expect("reads");
    assert_eq!(both.times_s(), [0.0, 0.01, 0.05]);
    assert_eq!((both.start_s(), both.end_s()), (0.0, 0.05));
    assert_eq!(both.force.as_ref().map(|force| force.forces_n()), Some(&[0.0, 2.0, 5.0][..]));
    assert_eq!(both.position.as_ref().map(|position| position.positions_m()), Some(&[0.0, 0.001, 0.009][..]));

    let shuffled =
        "# a recording\nhammer_m,position_m, time_s ,note,force_N\nx,0,0,,0\n,1e-3,0.01,\"a\",2\n,9e-3,.05,b,+5\n";
    assert_eq!(Series::parse(shuffled, "").as_ref(), Ok(&both));
    let quoted = "\"time_s\",\"force_N\",\"position_m\"\r\n\"0\",0,0\r\n0.01,2,0.001\r\n\r\n0.05,5,0.009";
    assert_eq!(Series::parse(quoted, "").as_ref(), Ok(&both));
    assert_eq!(
        Series::parse("\u{feff}time_s,force_N,position_m\n0,0,0\n0.01,2,0.001\n0.05,5,0.009\n", "").as_ref(),
        Ok(&both)
    );

    let force = Series::parse("time_s,force_N\n0,0\n1,1\n", "").expect("reads");
    assert!(force.position.is_none());
    let position = Series::parse("time_s,position_m\n-1,0\n1,0.01\n", "").expect("reads");
    assert!(position.force.is_none());
    assert_eq!(position.start_s(), -1.0);
    let (y, v, _) = position.position.expect("a position").at(0.0, &mut Cursor::default());
    // The smooth step's middle: half way, at 3/2 of the mean velocity.
    assert!((y - 0.005).abs() < 1e-15 && (v - 0.0075).abs() < 1e-15);
}

#[test]
fn every_fault_names_line_column_and_remedy() {
    let head = "time_s,force_N,position_m\n0,0,0\n";
    // (text, line, column, then what message, found and expected contain)
    let cases: &[(String, u64, &str, [&str; 3])] = &[
        (String::new(), 0, "", ["empty", "", "time_s,force_N"]),
        ("\n\n".into(), 0, "", ["empty", "", ""]),
        ("# nothing\n".into(), 0, "", ["empty", "", ""]),
        ("time_s,force_N\n".into(), 1, "", ["no rows", "0 rows", "two rows"]),
        ("time_s,force_N\n0,1\n".into(), 2, "", ["one row", "1 row", "two rows"]),
        ("0,0\n1,1\n".into(), 1, "time_s", ["missing", "0,0", "`time_s`"]),
        ("force_N\n1\n2\n".into(), 1, "time_s", ["missing", "force_N", "`time_s`"]),
        ("time_s,hammer_m\n0,1\n".into(), 1, "force_N", ["neither", "time_s,hammer_m", "`position_m`"]),
        ("time_s,force_N,force_N\n0,1,1\n".into(), 1, "force_N", ["two columns", "", "one"]),
        ("time_s,time_s,force_N\n0,1,1\n".into(), 1, "time_s", ["two columns", "", "one"]),
        ("time_ms,force_N\n0,1\n".into(), 1, "time_ms", ["unit", "`time_ms`", "`time_s`"]),
        ("time_s,force\n0,1\n".into(), 1, "force", ["unit", "`force`", "`force_N`"]),
        ("time_s,force_N,position_mm\n0,1,1\n".into(), 1, "position_mm", ["unit", "`position_mm`", "`position_m`"]),
        ("Time (s);Force (N)\n0;1\n".into(), 1, "", ["commas", ";", ","]),
        (format!("{head}0.1,x,0\n"), 3, "force_N", ["not a number", "`x`", "a number"]),
        (format!("{head}0.1,,0\n"), 3, "force_N", ["not a number", "empty cell", "a number"]),
        (format!("{head}0.1,1 N,0\n"), 3, "force_N", ["not a number", "`1 N`", "a number"]),
        (format!("{head}0.1,NaN,0\n"), 3, "force_N", ["finite", "`NaN`", "finite"]),
        (format!("{head}0.1,1,-inf\n"), 3, "position_m", ["finite", "`-inf`", "finite"]),
        (format!("{head}0.1,1,1e999\n"), 3, "position_m", ["finite", "`1e999`", "finite"]),
        (format!("{head}nan,1,1\n"), 3, "time_s", ["finite", "`nan`", "finite"]),
        (format!("{head}0.1,1,0\n0.05,1,0\n"), 4, "time_s", ["backwards", "0.05", "more than 0.1"]),
        (format!("{head}0.1,1,0\n0.1,1,0\n"), 4, "time_s", ["twice", "0.1", "more than 0.1"]),
        (format!("{head}1e-13,1,0\n"), 3, "time_s", ["close together", "1", "more than 0"]),
        (format!("{head}1,1\n"), 3, "", ["does not fit", "2 cells", "3 cells"]),
        (format!("{head}1,1,0,0\n"), 3, "", ["does not fit", "4 cells", "3 cells"]),
        (format!("{head}1,\"1,0\n2,2,0\n"), 3, "", ["not closed", "`1,\"1,0`", "end of a cell"]),
        (format!("{head}1,20000,0\n"), 3, "force_N", ["too large", "`20000`", "newtons"]),
        (format!("{head}1,2,9.5\n"), 3, "position_m", ["too large", "`9.5`", "millimetres?"]),
        (format!("{head}1700000000,2,0\n"), 3, "time_s", ["too large", "`1700000000`", "seconds from the start"]),
        (format!("# one\n\n{head}# two\n0.1,x,0\n"), 6, "force_N", ["not a number", "`x`", "a number"]),
    ];
    for (text, line, column, says) in cases {
        let error = error_of(text);
        assert_eq!((error.line, error.column.as_str()), (*line, *column), "{text:?}: {error}");
        for (got, want) in [&error.message, &error.found, &error.expected].into_iter().zip(says) {
            assert!(got.contains(want), "{text:?}: `{want}` is not in {error}");
        }
        assert!(error.to_string().starts_with("stroke.csv:"), "{error}");
        assert!(!error.to_string().contains('\n'), "one line: {error}");
    }
}

#[test]
fn bytes_that_are_no_text() {
    let error = Series::read(&b"time_s,force_N\n0,0\n1,\xff\n"[..], "s.csv").expect_err("not UTF-8");
    assert_eq!((error.line, error.message.as_str()), (3, "the file is not UTF-8"));
    let error = Series::read(&b"time_s,force_\xff\n0,0\n1,1\n"[..], "s.csv").expect_err("not UTF-8");
    assert_eq!((error.line, error.message.as_str()), (1, "the file is not UTF-8"));
    let error = Series::read(std::io::repeat(0), "s.csv").expect_err("no table");
    assert!(error.message.contains("no table"), "{error}");
    let error = Series::load(Path::new("no/such/stroke.csv")).expect_err("no such file");
    assert!(error.to_string().starts_with("no/such/stroke.csv: cannot be read"), "{error}");
    assert!(Series::load(Path::new(env!("CARGO_MANIFEST_DIR"))).is_err(), "a folder");
}

/// Rows made as they are read, so that the test itself holds none of them.
struct Rows {
    next: u64,
    rows: u64,
    buffer: Vec<u8>,
    at: usize,
    read: u64,
}

impl Read for &mut Rows {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        if self.at == self.buffer.len() {
            self.buffer.clear();
            self.at = 0;
            while self.buffer.len() < 1 << 16 && self.next <= self.rows {
                let row = match self.next {
                    0 => "time_s,force_N\n".to_owned(),
                    n => format!("{}e-6,1\n", n),
                };
                self.buffer.extend_from_slice(row.as_bytes());
                self.next += 1;
            }
        }
        let count = out.len().min(self.buffer.len() - self.at);
        out[..count].copy_from_slice(&self.buffer[self.at..self.at + count]);
        self.at += count;
        self.read += count as u64;
        Ok(count)
    }
}

#[test]
fn ten_million_rows_are_refused_without_reading_them_all() {
    let mut rows = Rows { next: 0, rows: 2 * MAX_ROWS as u64, buffer: Vec::new(), at: 0, read: 0 };
    let start = Instant::now();
    let error = Series::read(&mut rows, "long.csv").expect_err("too many rows");
    assert_eq!(error.line, MAX_ROWS as u64 + 2, "the header and one row more than fit");
    assert!(error.message.contains("too many rows"), "{error}");
    assert!(rows.next < MAX_ROWS as u64 + 20_000, "stopped reading at row {}", rows.next);
    assert!(start.elapsed() < Duration::from_secs(30), "took {:?}", start.elapsed());
}

/// Columns that mean a known one in another unit or by another name are refused where it is missing, and never ignored.
#[test]
fn columns_in_other_units_are_not_ignored() {
    for (given, known) in [
        ("force_lbf", "`force_N`"),
        ("Force (kgf)", "`force_N`"),
        ("load_N", "`force_N`"),
        ("position_inch", "`position_m`"),
        ("travel_mm", "`position_m`"),
        ("Key travel [in]", "`position_m`"),
        ("depth", "`position_m`"),
        ("positionmm", "`position_m`"),
        ("hammer_head_mm", "`hammer_head_m`"),
        ("t_ms", "`time_s`"),
    ] {
        let others: Vec<&str> =
            ["time_s", "force_N", "position_m"].into_iter().filter(|name| known != format!("`{name}`")).collect();
        let error = Series::parse(&format!("{},{given}\n0,0,0\n1,1,1\n", others.join(",")), "test").unwrap_err();
        assert_eq!((error.column.as_str(), error.expected.as_str()), (given, known), "{error}");
    }
    // What a run writes, and what means something else, stands beside.
    let beside = "time_s,force_N,key_m,key_rad,hammer_rad,hammer_m,tail_m,load_cell_V,note,depth_of_field\n";
    let series = Series::parse(&format!("{beside}0,0,0,0,0,0,0,0,0,0\n1,1,0,0,0,0,0,0,0,0\n"), "test").unwrap();
    assert!(series.position.is_none() && series.hammer_head.is_none());
}
