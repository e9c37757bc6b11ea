//! Stroke files: what reads, and the one message that each thing gives that does not.

use std::io::Read;
use std::path::Path;
use std::time::{Duration, Instant};

use erard::stroke::{Columns, Cursor, Layout, MAX_ROWS, Recording, Role, Series, StrokeError};

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
        ("time_s,force\n0,1\n".into(), 1, "force", ["unit", "`force`", "`force_N`"]),
        (
            "time_s,force_N,position [furlong]\n0,1,1\n".into(),
            1,
            "position [furlong]",
            ["unit", "`furlong`", "mm, um, nm, in"],
        ),
        ("time_s;force_N\n0;1\n1;1.000,5\n".into(), 3, "force_N", ["not a number", "`1.000,5`", "0.25"]),
        ("time_s;force_N\n0;1,5\n1;1.5\n".into(), 3, "force_N", ["commas and", "`1.5`", "`,` before"]),
        ("time_s,force_N\n0,1\n1,\n".into(), 1, "force_N", ["empty cells", "1 number", "two numbers"]),
        ("Time (ms);Force (N)\n0;1\n5;2\n4;3\n".into(), 4, "Time (ms)", ["backwards", "0.004 s", "0.005 s"]),
        (format!("{head}0.1,x,0\n"), 3, "force_N", ["not a number", "`x`", "a number"]),
        (format!("{head},1,0\n"), 3, "time_s", ["not a number", "empty cell", "a number"]),
        (format!("{head}0.1,1 N,0\n"), 3, "force_N", ["not a number", "`1 N`", "a number"]),
        ("time_s,force_N\n0,1\n1,NaN\n".into(), 1, "force_N", ["empty cells", "1 number", "two numbers"]),
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
    assert!(error.message.contains("not a table"), "{error}");
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

/// Columns in another known unit are converted; without a unit, or in one that is not known, they are refused, and
/// never ignored.
#[test]
fn columns_in_other_units() {
    let others = |known: &str| {
        let names = ["time_s", "force_N", "position_m"].into_iter().filter(|name| *name != known);
        names.collect::<Vec<_>>().join(",")
    };
    // One of each, in SI.
    for (given, known, si) in [
        ("force_lbf", "force_N", 4.448_221_615_260_5),
        ("Force (kgf)", "force_N", 9.806_65),
        ("load_N", "force_N", 1.0),
        ("F [gf]", "force_N", 9.806_65e-3),
        ("position_inch", "position_m", 0.025_4),
        ("travel_mm", "position_m", 1e-3),
        ("Key travel [in]", "position_m", 0.025_4),
        ("positionmm", "position_m", 1e-3),
        ("key_m", "position_m", 1.0),
        ("t_ms", "time_s", 1e-3),
        ("Time (\u{b5}s)", "time_s", 1e-6),
    ] {
        let text = format!("{},{given}\n0,0,0\n1,1,1\n", others(known));
        let series = Series::parse(&text, "test").unwrap_or_else(|error| panic!("{error}"));
        let last = match known {
            "time_s" => series.end_s(),
            "force_N" => series.force.unwrap().forces_n()[1],
            _ => series.position.unwrap().positions_m()[1],
        };
        assert!((last / si - 1.0).abs() < 1e-12, "{given}: {last}");
    }
    let head = Series::parse("time_s,force_N,hammer_head_mm\n0,0,0\n1,1,47\n", "").unwrap().hammer_head.unwrap();
    assert!((head.positions_m()[1] - 0.047).abs() < 1e-15);
    for (given, known) in
        [("depth", "position_m"), ("Force (V)", "force_N"), ("time", "time_s"), ("travel [px]", "position_m")]
    {
        let error = Series::parse(&format!("{},{given}\n0,0,0\n1,1,1\n", others(known)), "test").unwrap_err();
        assert!(
            error.column == given && error.message.contains("unit") && error.expected.contains("one of "),
            "{error}"
        );
    }
    // Columns with another meaning are ignored.
    let beside = "time_s,force_N,key,key_rad,hammer_rad,hammer_m,tail_m,load_cell_V,note,depth_of_field\n";
    let series = Series::parse(&format!("{beside}0,0,0,0,0,0,0,0,0,0\n1,1,0,0,0,0,0,0,0,0\n"), "test").unwrap();
    assert!(series.position.is_none() && series.hammer_head.is_none());
}

/// The same numbers, as laboratories write them.
#[test]
fn one_recording_in_many_hands() {
    let plain = "time_s,force_N,position_m\n0,0,0\n0.01,2.5,0.001\n0.05,5,0.0095\n";
    let plain = Series::parse(plain, "").unwrap();
    let columns: Columns = "time=Time (s),position=Displacement, laser (mm),force=F [gf]".parse().unwrap();
    for (text, asked) in [
        ("t / ms;Force (N);Travel (mm)\n0;0;0\n10;2,5;1\n50;5;9,5\n;;\n", None),
        ("time_s\tforce_N\tposition_mm\n% a note\n0\t0\t0\n// another\n0,01\t2,5\t1\n0,05\t5\t9,5\n", None),
        ("Time,Force,Travel\n(ms),(N),(mm)\n\n0,0,0\n10,2.5,1\n50,5,9.5\n", None),
        (
            "Rig 3;2026-03-01\nSample rate;1 kHz\nF [gf];Time (s);\"Displacement, laser (mm)\";F [gf] raw\n0;0;0;1\n\
             254,92905324448205;0,01;1;1\n509,8581064889641;0,05;9,5;1\n",
            Some(&columns),
        ),
    ] {
        let recording = Recording::read(text.as_bytes(), "t.csv", asked.unwrap_or(&Columns::default()));
        let series = recording.unwrap_or_else(|error| panic!("{error}")).series().unwrap();
        let near = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near(series.times_s(), plain.times_s()), "{text}");
        let forces = |s: &Series| s.force.as_ref().unwrap().forces_n().to_vec();
        assert!(near(&forces(&series), &forces(&plain)), "{text}: {:?}", forces(&series));
        let positions = |s: &Series| s.position.as_ref().unwrap().positions_m().to_vec();
        assert!(near(&positions(&series), &positions(&plain)), "{text}: {:?}", positions(&series));
    }
}

/// An empty cell is a gap, over which its own channel is interpolated: channels of two rates stand in one file.
#[test]
fn gaps() {
    let text = "time_s,force_N,position_m\n0,0,0\n0.01,1,\n0.02,,\n0.03,3,\n0.04,4,0.004\n";
    let recording = Recording::read(text.as_bytes(), "", &Columns::default()).unwrap();
    // NumPy writes NaN instead.
    let written = "time_s,force_N,position_m\n0,0,0\n0.01,1,nan\n0.02,NaN,nan\n0.03,3,\n0.04,4,0.004\n";
    let same = Recording::read(written.as_bytes(), "", &Columns::default()).unwrap();
    assert_eq!(same.series().unwrap(), recording.series().unwrap());
    let gaps = |role| recording.channel(role).unwrap().gaps(&recording.time_s);
    assert_eq!(gaps(Role::Force).rows, 1);
    assert!((gaps(Role::Force).longest_s - 0.02).abs() < 1e-15);
    assert_eq!(gaps(Role::Position).rows, 3);
    assert!((gaps(Role::Position).longest_s - 0.04).abs() < 1e-15);
    let series = recording.series().unwrap();
    assert_eq!(series.force.unwrap().times_s(), [0.0, 0.01, 0.03, 0.04]);
    assert_eq!(series.position.unwrap().times_s(), [0.0, 0.04]);
}

/// Columns that are numbers already, as from Parquet; and a table without titles, by numbers.
#[test]
fn without_a_text() {
    let layout = Layout::of(&["t_ms", "travel_mm", "note"], &Columns::default(), "t.parquet").unwrap();
    assert_eq!(layout.columns.iter().map(|column| column.index).collect::<Vec<_>>(), [0, 1]);
    let taken =
        Recording::from_columns(layout.clone(), "t.parquet", &[&[0.0, 1.0, 2.0], &[0.0, f64::NAN, 9.5]]).unwrap();
    assert_eq!(taken.series().unwrap().position.unwrap().positions_m(), [0.0, 0.0095]);
    let error = Recording::from_columns(layout, "t.parquet", &[&[0.0, 1.0], &[0.0, f64::INFINITY]]).unwrap_err();
    assert_eq!((error.line, error.column.as_str()), (2, "travel_mm"));
    let columns: Columns = "time=#1:ms,force=#3:N".parse().unwrap();
    let bare = Recording::read(&b"0,7,0\n5,7,1.5\n9,7,2\n"[..], "", &columns).unwrap();
    assert_eq!(bare.time_s, [0.0, 0.005, 0.009]);
    assert_eq!(bare.channels[0].values, [0.0, 1.5, 2.0]);
}

/// Forces and slopes are cubic pieces in Hermite's form: another program that has them has the force.
#[test]
fn slopes_make_the_same_force() {
    let series = Series::parse("time_s,force_N\n0,0\n0.01,2\n0.05,5\n0.06,4.5\n", "").expect("reads");
    let force = series.force.expect("a force");
    let (t, f, m) = (force.times_s(), force.forces_n(), force.slopes_n_per_s());
    assert_eq!(m.len(), t.len());
    let mut cursor = Cursor::default();
    for i in 0..t.len() - 1 {
        for s in [0.0, 0.25, 0.6, 1.0] {
            let h = t[i + 1] - t[i];
            let (s2, s3) = (s * s, s * s * s);
            let hermite = (2.0 * s3 - 3.0 * s2 + 1.0) * f[i]
                + (s3 - 2.0 * s2 + s) * h * m[i]
                + (3.0 * s2 - 2.0 * s3) * f[i + 1]
                + (s3 - s2) * h * m[i + 1];
            assert!((force.at(t[i] + s * h, &mut cursor) - hermite).abs() < 1e-12, "{i} {s}");
        }
    }
}
