//! Streams as other people's loggers, keybeds and hybrids send them, from what their users report. What is right was
//! written down before each was played for the first time; `first` says what came out then, or what the code at that
//! time would have made of it where that was plain to see.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use erard_live::profile::{Profile, Sensed, Stops};
use erard_live::sensor::Law;
use erard_live::stream::{Head, Reader, SensorUnit};
use erard_live::{Live, Options, Report, SensorKind};

use crate::common::{GRAND, Press, offs, ons, options};
use crate::contacts::law;
use crate::hammers::profile as hammers;

/// What is right of a stream.
enum Right {
    /// So many notes, which all end. The first one's speed is within so many counts of the true one.
    Notes(usize, f64),
    /// No note, and a reason that contains this.
    Silent(&'static str),
    /// No line is a sample, and the first fault contains this.
    Refused(&'static str),
}

struct Case {
    /// Who sends so, or who reports it.
    source: &'static str,
    habit: &'static str,
    text: String,
    profile: Profile,
    /// The hammer's speed, m/s.
    speed: f64,
    right: Right,
    /// What the report must say besides.
    counted: fn(&Report) -> bool,
    /// What came out the first time, where that was not right.
    first: &'static str,
}

impl Case {
    /// What came out, where it is not right.
    fn wrong(&self) -> Option<String> {
        let mut lines = self.text.split_inclusive('\n');
        let head = match Head::parse(lines.next().unwrap()) {
            Ok(head) => head,
            Err(fault) => {
                let is_right = matches!(self.right, Right::Refused(part) if fault.to_string().contains(part));
                return (!is_right).then(|| fault.to_string());
            }
        };
        let mut reader = Reader::new(head);
        let grands = [GRAND.clone(), GRAND.clone()];
        let of_mm = head.quantity == SensorUnit::Millimetres;
        let options = Options { quantity: head.quantity, ..options(SensorKind::Action, false) };
        let mut live = Live::new(&grands, Some(&self.profile).filter(|_| !of_mm), options, &mut |_| true).unwrap();
        let (mut events, mut faults) = (Vec::new(), Vec::new());
        for line in lines {
            match reader.received(line) {
                Ok(samples) if samples.is_empty() && reader.take_restart() => live.restart(),
                Ok(samples) => samples.iter().for_each(|one| live.take(one, &mut |event| events.push(event))),
                Err(fault) => faults.push(fault.to_string()),
            }
        }
        live.let_go(&mut |event| events.push(event));
        let (report, ons) = (live.report(), ons(&events));
        let off_by = ons.first().map_or(f64::INFINITY, |[_, own]| (25.0 * (own / self.speed).log2()).abs());
        let is_right = match self.right {
            Right::Notes(count, counts) => {
                (ons.len(), offs(&events).len()) == (count, count) && (count == 0 || off_by <= counts)
            }
            Right::Silent(part) => report.silence.as_ref().is_some_and(|why| why.contains(part)),
            Right::Refused(part) => report.samples == 0 && faults.first().is_some_and(|fault| fault.contains(part)),
        };
        let came = || format!("{ons:?}, off by {off_by:.2}, {:?}, {report:?}", faults.first());
        (!is_right || !(self.counted)(&report)).then(came)
    }
}

fn nothing(_: &Report) -> bool {
    true
}

const REST: f64 = 3500.0;
const PRESSED: f64 = 700.0;

fn keys() -> Profile {
    let stops = Stops { rest: REST, pressed: PRESSED };
    Profile {
        sensed: Sensed::Keys,
        law: Law::Linear {},
        travel_m: 10e-3,
        pressure_is_depth: false,
        keys: BTreeMap::from([(1, stops), (2, stops)]),
    }
}

/// Readings of a press of key 1 at a rate, Hz: instant, us, and reading.
fn readings(press: &Press, rate_hz: u32) -> Vec<(u64, f64)> {
    let reading = |k: u32| (REST - 280e3 * press.at(f64::from(k) / f64::from(rate_hz))).round();
    (0..rate_hz * 9 / 10).map(|k| (1_000_000 * u64::from(k) / u64::from(rate_hz), reading(k))).collect()
}

/// A text of these.
fn text(head: &str, all: &[(u64, f64)], line: impl Fn(usize, u64, f64) -> String) -> String {
    let lines = all.iter().enumerate().map(|(n, (us, raw))| line(n, *us, *raw));
    std::iter::once(format!("{head}\n")).chain(lines).collect()
}

const HEAD: &str = "time_us,key,raw";

/// Loggers.
fn loggers(press: &Press) -> Vec<Case> {
    let (speed, all) = (press.impacts[0][1], readings(press, 1000));
    let fast = readings(press, 4000);
    let plain = |_: usize, us: u64, raw: f64| format!("{us},1,{raw}\n");
    let case = |source, habit, text: String, right, counted, first| Case {
        source,
        habit,
        text,
        profile: keys(),
        speed,
        right,
        counted,
        first,
    };
    let one = || Right::Notes(1, 0.6);
    let wrapped = |us: u64| (us + (1 << 32) - 60_000) % (1 << 32);
    let torn = |n: usize, us: u64, raw: f64| match n + 1 == all.len() {
        true => format!("{us},1,{:.1}", raw.to_string()),
        false => plain(n, us, raw),
    };
    vec![
        case(
            "loggers that are switched off",
            "the last line is torn: 3 of 3499, a key at its bottom",
            text(HEAD, &all, torn),
            one(),
            nothing,
            "a second note, of 1.2 m/s",
        ),
        case(
            "sparkfun/OpenLog_Artemis",
            "lines end as on Windows",
            text("time_us,key,raw\r", &all, |_, us, raw| format!("{us},1,{raw}\r\n")),
            one(),
            nothing,
            "",
        ),
        case(
            "spreadsheets",
            "a mark of the order of bytes, and blanks behind the commas",
            text("\u{feff}time_us, key, raw", &all, |_, us, raw| format!(" {us}, 1, {raw} \n")),
            one(),
            nothing,
            "",
        ),
        case(
            "NVlabs/FPSci 318, xeonfusion/VSCaptureMP 5",
            "a counter of 32 bits wraps around within a press",
            text(HEAD, &all, |_, us, raw| format!("{},1,{raw}\n", wrapped(us))),
            one(),
            nothing,
            "",
        ),
        case(
            "loggers that print milliseconds",
            "four readings with the same stamp",
            text("time_s,key,raw", &fast, |_, us, raw| format!("{:.3},1,{raw}\n", (us / 1000) as f64 * 1e-3)),
            Right::Notes(1, 1.5),
            |report| report.out_of_order == 2700,
            "",
        ),
        case(
            "Arduino: millis() for micros()",
            "milliseconds under `time_us`",
            text(HEAD, &all, |_, us, raw| format!("{},1,{raw}\n", us / 1000)),
            Right::Silent("is the time in milliseconds"),
            nothing,
            "silent, and the reason was another: no key goes down fast enough",
        ),
        case(
            "Arduino: micros()",
            "microseconds under `time_s`",
            text("time_s,key,raw", &all, plain),
            Right::Silent("is the time in milliseconds"),
            nothing,
            "silent, and the reason was another: no key goes deep enough",
        ),
        case(
            "Arduino: millis()",
            "milliseconds under `time_s`",
            text("time_s,key,raw", &all[..90], |_, us, raw| format!("{},1,{raw}\n", us / 1000)),
            Right::Silent("is the time in milliseconds"),
            nothing,
            "silent, and there was no such reason",
        ),
        case(
            "openbikesensor 142",
            "semicolons for commas",
            text("time_us;key;raw", &all, |_, us, raw| format!("{us};1;{raw}\n")),
            Right::Refused("expected a header such as"),
            nothing,
            "",
        ),
        case(
            "pandas, QUOTE_ALL",
            "titles in quotation marks",
            text("\"time_us\",\"key\",\"raw\"", &all, plain),
            Right::Refused("expected a header such as"),
            nothing,
            "",
        ),
        case(
            "numpy.savetxt",
            "every number as a float, the key's, too",
            text(HEAD, &all, |_, us, raw| format!("{:.18e},{:.18e},{raw:.18e}\n", us as f64, 1.0)),
            one(),
            nothing,
            "every line was refused",
        ),
        case(
            "pandas, a column with gaps",
            "the key as 1.0",
            text(HEAD, &all, |_, us, raw| format!("{us},1.0,{raw}\n")),
            one(),
            nothing,
            "every line was refused",
        ),
        case(
            "pandas, a column with gaps",
            "every tenth reading is nan",
            text(HEAD, &all, |n, us, raw| if n % 10 == 3 { format!("{us},1,nan\n") } else { plain(n, us, raw) }),
            Right::Notes(1, 1.0),
            nothing,
            "",
        ),
        case(
            "gzweigle/open-hybrid-piano 16",
            "the converter saturates at 95 % of the travel",
            text(HEAD, &all, |_, us, raw| format!("{us},1,{}\n", raw.max(840.0))),
            Right::Notes(1, 1.5),
            nothing,
            "",
        ),
        case(
            "gzweigle/open-hybrid-piano 27",
            "crosstalk: a neighbour reads 3 % of the key",
            text(HEAD, &all, |_, us, raw| format!("{us},1,{raw}\n{us},2,{}\n", (REST - 0.03 * (REST - raw)).round())),
            one(),
            nothing,
            "",
        ),
        case(
            "jkominek/piano-conversion",
            "nobody plays, and the converter is noisy",
            text(HEAD, &all, |n, us, _| format!("{us},1,{}\n", REST - [0.0, 3.0, -2.0, 1.0][n % 4])),
            Right::Silent("no key goes deep enough"),
            nothing,
            "",
        ),
        case(
            "keys by their MIDI numbers",
            "the lowest A is 21, on a profile of two keys",
            text(HEAD, &all, |_, us, raw| format!("{us},21,{raw}\n")),
            Right::Silent("the calibration has"),
            |report| report.uncalibrated == 900,
            "silent, without a reason",
        ),
        case(
            "devices that think in MIDI",
            "the sustain pedal from 0 to 127",
            text(HEAD, &all, |n, us, raw| {
                let pedal = if n == 20 { format!("{us},sustain,127\n") } else { String::new() };
                format!("{us},1,{raw}\n{pedal}")
            }),
            one(),
            |report| report.samples == 901,
            "",
        ),
        case(
            "PaxInstruments/t400-firmware 154",
            "the header comes again every hundred lines, and the clock goes on",
            text(
                HEAD,
                &all,
                |n, us, raw| if n % 100 == 99 { format!("{us},1,{raw}\n{HEAD}\n") } else { plain(n, us, raw) },
            ),
            one(),
            |report| report.new_clocks == 0,
            "seven notes: every header began a new clock, and held keys struck again",
        ),
    ]
}

/// Edges: instants, ms, contacts and states.
fn edges(all: &[(f64, usize, &str)]) -> String {
    let mut text = String::from("time_us,key,contact,state\n");
    for (ms, contact, state) in all {
        writeln!(text, "{:.0},1,{contact},{state}", 1e3 * (ms + 1000.0)).unwrap();
    }
    text
}

/// Keybeds with two contacts, of which 10 ms are 1 m/s.
fn keybeds() -> Vec<Case> {
    let case = |source, habit, text: String, right, counted, first| Case {
        source,
        habit,
        text,
        profile: Profile::of_contacts(law(2)),
        speed: 1.0,
        right,
        counted,
        first,
    };
    let (made, open) = ("made", "open");
    let press = [(0.0, 1, made), (10.0, 2, made), (200.0, 2, open), (215.0, 1, open)];
    let later = |ms: f64| press.map(|(at, contact, state)| (at + ms, contact, state));
    let one = || Right::Notes(1, 0.01);
    // Every state in every scan.
    let mut levels = String::from("time_us,key,contact,state\n");
    for ms in 0..300_u32 {
        let is = |from: u32, to: u32| if (from..to).contains(&ms) { made } else { open };
        writeln!(levels, "{},1,1,{}\n{0},1,2,{}", 1000 * ms, is(50, 265), is(60, 250)).unwrap();
    }
    vec![
        case(
            "oxesoft/keyboardscanner 21 (TP40)",
            "wires that touch: both contacts close in one scan",
            edges(&[(0.0, 1, made), (0.0, 2, made), (200.0, 2, open), (200.0, 1, open)]),
            Right::Notes(1, 100.0),
            |report| report.fast_strokes == 1,
            "one note, and nothing said of it",
        ),
        case(
            "oxesoft/keyboardscanner 17",
            "a changeover switch: contact 1 opens as the key leaves its rest",
            edges(&[(-500.0, 1, made), (0.0, 1, open), (10.0, 2, made), (200.0, 2, open), (215.0, 1, made)]),
            Right::Silent("none above it"),
            |report| report.untimed_strokes == 1,
            "",
        ),
        case(
            "tttapa/Control-Surface 933",
            "contacts numbered from below",
            edges(&press.map(|(ms, contact, state)| (ms, 3 - contact, state))),
            Right::Silent("close before upper ones"),
            nothing,
            "",
        ),
        case(
            "blahlicus/animus-family 12",
            "an upper contact that chatters for 4 ms, longer than its bounces may last",
            edges(
                &[
                    &[
                        (0.0, 1, made),
                        (1.0, 1, open),
                        (1.5, 1, made),
                        (2.5, 1, open),
                        (3.0, 1, made),
                        (4.0, 1, open),
                        (4.2, 1, made),
                    ][..],
                    &press[1..],
                ]
                .concat(),
            ),
            Right::Notes(1, 20.0),
            nothing,
            "",
        ),
        case(
            "keyboardio/Kaleidoscope 180",
            "a lower contact that chatters for 6 ms",
            edges(
                &[&press[..2], &[(11.0, 2, open), (13.0, 2, made), (13.5, 2, open), (16.0, 2, made)], &press[2..]]
                    .concat(),
            ),
            one(),
            nothing,
            "",
        ),
        case(
            "yurikhan/teck 7",
            "both contacts chatter as the key comes up",
            edges(
                &[
                    &press[..3],
                    &[
                        (200.5, 2, made),
                        (201.0, 2, open),
                        (215.0, 1, open),
                        (215.4, 1, made),
                        (215.9, 1, open),
                        (217.5, 1, made),
                        (217.8, 1, open),
                    ],
                ]
                .concat(),
            ),
            one(),
            nothing,
            "",
        ),
        case(
            "dirty keybeds",
            "the lower contact never closes",
            edges(&[press[0], press[3]]),
            Right::Silent("no key comes to its lowest contact"),
            nothing,
            "",
        ),
        case(
            "oxesoft/keyboardscanner",
            "half a press before a whole one",
            edges(&[&[(0.0, 1, made), (80.0, 1, open)][..], &later(300.0)].concat()),
            one(),
            nothing,
            "",
        ),
        case(
            "scanners without memory",
            "every state in every scan",
            levels,
            one(),
            |report| report.samples == 600 && report.bounces == 0,
            "",
        ),
        case(
            "serial lines that overflow",
            "the opening of an upper contact is lost: so is the next note, and that is said",
            edges(&[&press[..3], &later(300.0)[..]].concat()),
            one(),
            |report| report.untimed_strokes == 1,
            "",
        ),
        case(
            "scanners that print numbers",
            "states 1 and 0",
            edges(&press.map(|(ms, contact, state)| (ms, contact, if state == made { "1" } else { "0" }))),
            Right::Refused("expected `made` or `open`"),
            nothing,
            "",
        ),
        case(
            "scanners that count from 0",
            "contacts 0 and 1",
            edges(&press.map(|(ms, contact, state)| (ms, contact - 1, state))),
            Right::Silent("lowest contact"),
            nothing,
            "",
        ),
        case(
            "zynthian 794",
            "the stream ends while a key is held",
            edges(&press[..2]),
            one(),
            |report| report.unseen_releases == 1,
            "",
        ),
        case(
            "jazz-soft: minutes between notes",
            "nothing for twenty minutes, then another note",
            edges(&[&press[..], &later(1_200_000.0)[..]].concat()),
            Right::Notes(2, 0.01),
            |report| report.stream_gaps == 0,
            "",
        ),
    ]
}

/// A text of hammers: readings of a head, of 12 bits, at instants of a press, s, by a function of its share of the way;
/// and of a sensor at the key.
fn heads(
    press: &Press,
    rate_hz: f64,
    has_release: bool,
    stamp_s: impl Fn(u32) -> f64,
    share: impl Fn(u32, f64) -> f64,
) -> String {
    let whole_m = hammers(false).travel_m;
    let mut text = format!("{HEAD}\n");
    for k in 0..(press.lasts_s() * rate_hz) as u32 {
        let t = f64::from(k) / rate_hz;
        let us = 1e6 * (t + stamp_s(k) + 1.0);
        writeln!(text, "{us:.0},1,{:.0}", 3500.0 - 3000.0 * share(k, press.head(t) / whole_m)).unwrap();
        if has_release {
            writeln!(text, "{us:.0},1:release,{:.0}", 200.0 + 300e3 * press.at(t)).unwrap();
        }
    }
    text
}

/// Hybrids that sense the hammer.
fn hybrids(press: &Press) -> Vec<Case> {
    let case = |source, habit, (speed, text): (f64, String), profile: Profile, right, counted, first| Case {
        source,
        habit,
        text,
        profile,
        speed,
        right,
        counted,
        first,
    };
    let speed = press.impacts[0][1];
    let on_time = |_: u32| 0.0;
    let of = |share: fn(u32, f64) -> f64| (speed, heads(press, 4000.0, false, on_time, share));
    let one = || Right::Notes(1, 3.0);
    let bottom_m = 10.5e-3;
    let slow = Press::along(&GRAND, &[[0.08, bottom_m], [0.25, bottom_m], [1.5, 0.0]]);
    let slow_speed = slow.impacts[0][1];
    // A flick: the head meets its string, and the key does not come to where its damper lifts.
    let mut flick = format!("{HEAD}\n");
    for k in 0..400_u32 {
        let ms = 0.25 * f64::from(k);
        let share = match ms - 20.0 {
            t if (0.0..23.0).contains(&t) => t / 23.0,
            t if (23.0..69.0).contains(&t) => 1.0 - (t - 23.0) / 46.0,
            _ => 0.0,
        };
        let key_mm = if (20.0..60.0).contains(&ms) { 3.0 } else { 0.0 };
        writeln!(
            flick,
            "{:.0},1,{:.0}\n{0:.0},1:release,{:.0}",
            1e3 * ms,
            3500.0 - 3000.0 * share,
            200.0 + 300.0 * key_mm
        )
        .unwrap();
    }
    vec![
        case(
            "gzweigle/open-hybrid-piano 13",
            "a slow release lifts the hammer as the jack slips below the knuckle",
            (slow_speed, heads(&slow, 3333.0, false, on_time, |_, x| x)),
            hammers(false),
            one(),
            |report| report.lifts > 0,
            "",
        ),
        case(
            "gzweigle/open-hybrid-piano 123",
            "a flick: the hammer strikes, the damper does not rise",
            (2.0, flick),
            hammers(true),
            Right::Notes(1, 3.0),
            nothing,
            "",
        ),
        case(
            "gzweigle/open-hybrid-piano 120",
            "stamps that jitter by 50 us",
            (speed, heads(press, 3333.0, false, |k| 1e-6 * f64::from(k * 7919 % 101) - 50e-6, |_, x| x)),
            hammers(false),
            one(),
            nothing,
            "",
        ),
        case(
            "gzweigle/open-hybrid-piano 16",
            "the sensor saturates at 90 % of the way",
            of(|_, x| x.min(0.9)),
            hammers(false),
            Right::Silent("below it"),
            nothing,
            "",
        ),
        case(
            "gzweigle/open-hybrid-piano 47",
            "a reading that is an outlier: at rest, while the head rises and while it is checked",
            of(|k, x| if [100, 300, 1500].contains(&k) { 1.0 } else { x }),
            hammers(false),
            one(),
            nothing,
            "three notes, the first for the outlier",
        ),
        case(
            "gzweigle/open-hybrid-piano 131",
            "the string lies 5 % farther than the stop of the calibration",
            of(|_, x| 1.05 * x),
            hammers(false),
            one(),
            nothing,
            "",
        ),
        case(
            "gzweigle/open-hybrid-piano 131",
            "the string lies 1 % nearer than the stop of the calibration",
            of(|_, x| 0.99 * x),
            hammers(false),
            one(),
            nothing,
            "",
        ),
        case(
            "gzweigle/open-hybrid-piano 64",
            "the piano shakes: 0.3 % of the way at 30 Hz",
            of(|k, x| x + 3e-3 * (f64::from(k) * 30.0 * std::f64::consts::TAU / 4000.0).sin()),
            hammers(false),
            one(),
            nothing,
            "",
        ),
    ]
}

#[test]
fn streams_of_others_are_played_as_was_written_down_before() {
    let press = Press::to(1.5);
    let all: Vec<Case> = [loggers(&press), keybeds(), hybrids(&press)].into_iter().flatten().collect();
    assert!(all.len() >= 40, "{}", all.len());
    let mut wrong = Vec::new();
    for case in &all {
        println!(
            "{} ({}): {}",
            case.habit,
            case.source,
            if case.first.is_empty() { "right at once" } else { case.first }
        );
        wrong.extend(case.wrong().map(|came| format!("{} ({}): {came}", case.habit, case.source)));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
