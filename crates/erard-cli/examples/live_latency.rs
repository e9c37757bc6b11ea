//! How long after the simulated impact `erard live` hands its bytes over, through pipes, in real time.
//!
//! `cargo run --release -p erard-cli --example live_latency [SECONDS [RATE_HZ [KEYS]]]`, after `cargo build --release
//! -p erard-cli`. A sender presses keys of a piano and writes samples at their instants; the true impacts are those of
//! the same stream, played here before. The table is of this machine while it did whatever else it was doing.

use std::io::{Read, Write};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use erard::keyboard::Keyboard;
use erard::stroke::least_jerk;
use erard_cli::print_line;
use erard_cli::printer::OutputMode;
use erard_cli::session::Session;
use erard_cli::table::Table;
use erard_live::stream::{Of, Sample, SensorUnit};
use erard_live::{Event, Live, Options, SensorKind};

/// Rates, Hz, and keys that are pressed at once.
const RATES_HZ: [u32; 2] = [1000, 4000];
const VOICES: [usize; 2] = [1, 10];
/// A press begins every so often, s, and the key is held for so long, s.
const EVERY_S: f64 = 0.4;
const HELD_S: f64 = 0.2;
/// The key goes so deep, mm.
const DEPTH_MM: f64 = 9.9;
/// A key's first press, s.
const FIRST_S: f64 = 0.2;

fn share(t: f64) -> f64 {
    least_jerk(t.clamp(0.0, 1.0))[0]
}

/// Depth of a voice's key, mm: presses that take 40 to 120 ms, each another time.
fn depth_mm(voice: usize, t: f64) -> f64 {
    let n = ((t - FIRST_S) / EVERY_S).floor();
    if n < 0.0 {
        return 0.0;
    }
    let within = t - FIRST_S - n * EVERY_S;
    let takes_s = 0.04 + 0.01 * ((n + voice as f64 * 3.0) % 9.0);
    DEPTH_MM * (share(within / takes_s) - share((within - HELD_S) / 0.08))
}

fn main() {
    let number = |n: usize| std::env::args().nth(n).and_then(|text| text.parse::<f64>().ok());
    let seconds = number(1).unwrap_or(20.0);
    let rates = number(2).map_or(RATES_HZ.to_vec(), |rate| vec![rate as u32]);
    let numbers = number(3).map_or(VOICES.to_vec(), |keys| vec![(keys as usize).clamp(1, 10)]);
    let program = std::env::current_exe().ok().and_then(|own| Some(own.parent()?.parent()?.join("erard")));
    let program = program.filter(|program| program.is_file()).expect("`cargo build --release -p erard-cli` first");
    let instruments =
        Keyboard::builtin("concert-grand").expect("it is built in").instruments().expect("they are sound");
    let heads = ["rate, Hz", "keys", "notes", "p50, ms", "p99, ms", "p99.9, ms", "longest, ms", "within 1 ms, %"];
    let mut rows = Vec::new();
    for ahead in [false, true] {
        for &rate in &rates {
            for &voices in &numbers {
                let samples: Vec<Sample> = (0..(seconds * f64::from(rate)) as u64)
                    .flat_map(|n| {
                        let time_s = n as f64 / f64::from(rate);
                        (0..voices).map(move |voice| {
                            let value = depth_mm(voice, time_s);
                            Sample { time_s, of: Of::Key(30 + 4 * voice), value }
                        })
                    })
                    .collect();
                let options = Options {
                    sensor: SensorKind::Action,
                    quantity: SensorUnit::Millimetres,
                    sensor_at_m: None,
                    travel_m: None,
                    ahead: false,
                    moved: None,
                    threads: 2,
                };
                let mut live = Live::new(&instruments, None, options, &mut |_| true).expect("they can be played");
                let mut truth: Vec<(usize, f64)> = Vec::new();
                samples.iter().for_each(|sample| {
                    live.take(sample, &mut |event| {
                        if let Event::On { key, time_s, .. } = event {
                            truth.push((key, time_s));
                        }
                    });
                });
                let came = sent(&program, &samples, ahead);
                let mut late_ms: Vec<f64> = Vec::new();
                for voice in 0..voices {
                    let key = 30 + 4 * voice;
                    let own = |all: &[(usize, f64)]| -> Vec<f64> {
                        all.iter().filter(|(k, _)| *k == key).map(|(_, t)| *t).collect()
                    };
                    let (true_s, came_s) = (own(&truth), own(&came));
                    assert_eq!(true_s.len(), came_s.len(), "a note was lost");
                    late_ms.extend(true_s.iter().zip(&came_s).map(|(t, c)| 1e3 * (c - t)));
                }
                late_ms.sort_by(f64::total_cmp);
                let at = |share: f64| late_ms[((share * late_ms.len() as f64) as usize).min(late_ms.len() - 1)];
                let within = late_ms.iter().filter(|ms| **ms <= 1.0).count() as f64 / late_ms.len() as f64;
                rows.push(vec![
                    format!("{rate}{}", if ahead { " ahead" } else { "" }),
                    voices.to_string(),
                    late_ms.len().to_string(),
                    format!("{:.2}", at(0.5)),
                    format!("{:.2}", at(0.99)),
                    format!("{:.2}", at(0.999)),
                    format!("{:.2}", at(1.0)),
                    format!("{:.1}", 100.0 * within),
                ]);
            }
        }
    }
    print_line!(Session::new(OutputMode::default()), "{}", Table::of(heads, rows));
}

/// Sends samples at their instants; returns when each note-on came back, s, and its key.
fn sent(program: &std::path::Path, samples: &[Sample], ahead: bool) -> Vec<(usize, f64)> {
    let mut command = Command::new(program);
    command.arg("live").args(ahead.then_some("--ahead"));
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("it starts");
    let (mut to, mut from) = (child.stdin.take().expect("a pipe"), child.stdout.take().expect("a pipe"));
    let mut errors = child.stderr.take().expect("a pipe");
    to.write_all(b"time_s,key,mm\n").expect("it listens");
    // `ready`.
    let mut ready = [0; 6];
    errors.read_exact(&mut ready).expect("it becomes ready");
    let begins = Instant::now() + Duration::from_millis(50);
    let reader = std::thread::spawn(move || {
        let (mut came, mut bytes) = (Vec::new(), [0_u8; 3]);
        while from.read_exact(&mut bytes).is_ok() {
            if bytes[0] == 0x90 {
                let at_s = Instant::now().saturating_duration_since(begins).as_secs_f64();
                came.push((bytes[1] as usize - 20, at_s));
            }
        }
        came
    });
    let words = std::thread::spawn(move || drop(errors.read_to_end(&mut Vec::new())));
    for scan in samples.chunk_by(|a, b| a.time_s == b.time_s) {
        let at = begins + Duration::from_secs_f64(scan[0].time_s);
        if let Some(left) = at.checked_duration_since(Instant::now()) {
            std::thread::sleep(left);
        }
        let mut lines = String::new();
        for sample in scan {
            if let Of::Key(key) = sample.of {
                lines.push_str(&format!("{:.6},{key},{:.4}\n", sample.time_s, sample.value));
            }
        }
        to.write_all(lines.as_bytes()).expect("it listens");
    }
    drop(to);
    let came = reader.join().expect("it reads");
    words.join().expect("it reads");
    child.wait().expect("it ends");
    came
}
