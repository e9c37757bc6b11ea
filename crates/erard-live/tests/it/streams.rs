//! Lines, heads, profiles and a cable.

use erard_live::cable::Cable;
use erard_live::stream::{Fault, Head, Of, Reader, Sample, SensorUnit};

#[test]
fn lines_are_read() {
    let head = Head::parse("time_us, key ,raw\r\n").unwrap();
    assert_eq!(head.quantity, SensorUnit::Raw);
    let mut reader = Reader::new(head);
    let sample = |time_s: f64, of: Of, value: f64| Ok(Some(Sample { time_s, of, value }));
    assert_eq!(reader.line("1500000,40,3121"), sample(1.5, Of::Key(40), 3121.0));
    let mut reader = Reader::new(head);
    assert_eq!(reader.line("4294967000,sustain,0.75"), sample(4294.967, Of::Pedal(64), 0.75));
    // The clock wraps around.
    let Ok(Some(after)) = reader.line("704,88,1") else { panic!() };
    assert!((after.time_s - 4294.968).abs() < 1e-9, "{after:?}");
    assert_eq!((reader.line("# words"), reader.line("  ")), (Ok(None), Ok(None)));
    // A stamp that is wrong wraps nothing around for those after it.
    let mut reader = Reader::new(head);
    let at = |line: Result<Option<Sample>, Fault>| line.unwrap().unwrap().time_s;
    assert_eq!(["1000000,40,1", "4294967295,40,1", "1001000,40,1"].map(|line| at(reader.line(line)))[2], 1.001);
    // A header begins anew; one of another quantity is no line.
    assert!(!reader.take_restart() && reader.line("time_us,key,raw") == Ok(None) && reader.take_restart());
    assert_eq!((at(reader.line("7,40,1")), reader.take_restart()), (7e-6, false));
    assert!(reader.line("time_us,key,mm").is_err());
    for (line, part) in [
        ("1,2", "three fields"),
        ("1,2,3,4", "three fields"),
        ("x,2,3", "time is `x`"),
        ("1,89,3", "key is `89`"),
        ("1,0,3", "key is `0`"),
        ("1,2,nan", "value is `nan`"),
        ("1,2,inf", "value is `inf`"),
        ("\u{1b}[2J,2,1", "time is `[2J`"),
    ] {
        let fault = reader.line(line).unwrap_err();
        assert!(fault.to_string().contains(part), "{line}: {fault}");
    }
    for head in ["", "0.001,40,3", "time_ms,key,mm", "time_s,key", "time_s,key,mm,more"] {
        assert!(matches!(Head::parse(head), Err(Fault::Head { .. })), "{head}");
    }
}

/// A last line without its end may be cut off where it ends in a number: it is no sample. One that ends in a word, and
/// one without content, is whole.
#[test]
fn a_line_without_its_end_is_left_out() {
    let mut reader = Reader::new(Head::parse("time_us,key,raw").unwrap());
    for line in ["1,40,3", "1,sustain,0", "1,40,3121.0 "] {
        assert!(matches!(reader.received(line), Err(Fault::NoEnd { .. })), "{line}");
        assert_eq!(reader.received(&format!("{line}\r\n")).unwrap().len(), 1);
    }
    for line in ["# words", "", "  "] {
        assert_eq!(reader.received(line), Ok(Vec::new()));
    }
    assert!(matches!(reader.received("1,4"), Err(Fault::Fields { .. })));
    let mut edges = Reader::new(Head::parse("time_us,key,contact,state").unwrap());
    assert_eq!(edges.received("1,40,1,made").unwrap().len(), 1);
    assert!(matches!(edges.received("1,40,1,mad"), Err(Fault::Edge { .. })));
    assert!(matches!(edges.received("1,sustain,1"), Err(Fault::NoEnd { .. })));
    let mut rows = Reader::of_rows("40,41", 1000.0).unwrap();
    assert!(matches!(rows.received("3121,3"), Err(Fault::NoEnd { .. })));
    assert!(matches!(rows.received("3121"), Err(Fault::Cells { .. })));
}

/// Ten note-ons at once take 9.6 ms; one alone 0.96.
#[test]
fn bytes_queue_for_a_cable() {
    let mut cable = Cable::default();
    for _ in 0..10 {
        cable.send(1.0, 3);
    }
    assert!((cable.longest_s - 9.6e-3).abs() < 1e-9, "{cable:?}");
    assert!((cable.send(2.0, 3) - 2.00096).abs() < 1e-9 && cable.bytes == 33);
}
