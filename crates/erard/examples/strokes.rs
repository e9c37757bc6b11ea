//! Writes the built-in strokes, `strokes/<nuance>-<touch>.csv`: `cargo run --release -p erard --example strokes`.
//!
//! Hands play them on the concert grand ([`erard::player::Hand`]): the force is the fingertip's, the position the key
//! front's. The hammer's speed at the string is the nuance's: 0.5 m/s (pp) to 5 m/s (ff), p, mf and f in equal ratios
//! between (with mp, which has no stroke). How long the key takes is not asked for; it is printed with the published
//! times.
//!
//! - Pressed: a hand of 0.2 kg rests on the key; its muscle's force rises at a constant rate until the hammer is on the
//!   string, and then falls to what holds the key. Only pp is led down instead, along the path of least jerk.
//! - Struck: a finger with a share of the hand arrives at the key with a speed, its muscle pressing on.
//!
//! From [`LET_GO_S`] on the hand leaves: its force is gone within 30 ms. All numbers of the hands are estimates.

use std::fmt::Write as _;
use std::path::Path;

use erard::instrument::Instrument;
use erard::run::Run;
use erard::run::Setup;
use erard::run::{HandStroke, press_by_hand};
use moreau::Settings;

/// Nuance, hammer speed (m/s), and what is published of the key's stroke, ms: Askenfelt and Jansson 1990 (p, f) and
/// 1988 (pp, ff), second-hand.
const NUANCES: [(&str, f64, &str); 5] =
    [("pp", 0.5, "over 100"), ("p", 0.79, "160"), ("mf", 1.99, ""), ("f", 3.15, "25"), ("ff", 5.0, "25")];
/// The key is let go at this instant, s, within [`RELEASE_S`]; the stroke ends at [`END_S`].
const LET_GO_S: f64 = 0.5;
const RELEASE_S: f64 = 0.030;
const END_S: f64 = 0.8;
/// What holds the key down after the blow, N.
const HOLD_N: f64 = 3.0;

/// One touch by the number that makes it louder, up to the blow and then whole.
fn play(grand: &Instrument, touch: &str, louder: f64, setup: &Setup) -> Run {
    let short = Setup { duration_s: 0.4, ..*setup };
    let held =
        |gesture: HandStroke| gesture.relaxing_at_the_blow(grand, &short, HOLD_N).expect("the concert grand runs");
    let gesture = match touch {
        "led" => HandStroke::led(1.0 / louder),
        "pressed" => held(HandStroke::pressed(louder)),
        _ => held(HandStroke::struck(louder)),
    };
    press_by_hand(grand, &gesture.leaving(LET_GO_S, RELEASE_S), setup, &mut |_| true).expect("the concert grand runs")
}

/// The number that gives the blow the wanted hammer speed, by bisection.
fn found(grand: &Instrument, touch: &str, speed: f64, [mut low, mut high]: [f64; 2]) -> f64 {
    let setup = Setup { settings: Settings::new(25e-6), record_every: Some(u64::MAX), ..Setup::new(0.45) };
    for _ in 0..24 {
        let middle = (low * high).sqrt();
        let reached = play(grand, touch, middle, &setup).events.hammer_speed_m_s().unwrap_or(0.0);
        if reached < speed { low = middle } else { high = middle }
    }
    high
}

/// Half a millisecond while it moves, more sparsely while it is held: unevenly sampled, as files may be.
fn kept(t: f64) -> bool {
    let ms = (t * 2e3).round() as u64;
    ms <= 500 || (1000..1200).contains(&ms) || ms.is_multiple_of(10)
}

fn write(folder: &Path, name: &str, how: &str, published: &str, run: &Run) {
    let mut text = String::from("time_s,force_N,position_m\n");
    for ((t, y), force) in run.time_s.iter().zip(&run.key_m).zip(&run.force_n).filter(|((t, _), _)| kept(**t)) {
        writeln!(text, "{t:.4},{force:.4},{y:.7}").expect("a string takes any text");
    }
    std::fs::write(folder.join(format!("{name}.csv")), text).expect("the folder `strokes` can be written");
    let e = &run.events;
    let ms = |s: Option<f64>| s.unwrap_or(f64::NAN) * 1e3;
    let start = ms(e.key_start_s);
    println!(
        "{name:12} {how:38} peak {:5.1} N  hammer {:.3} m/s  to the string {:5.1} ms  key stroke {:5.1} ms (published {published})  blows {}",
        run.peak_force_n,
        e.hammer_speed_m_s().unwrap_or(0.0),
        ms(e.hammer_contact_s()) - start,
        ms(e.key_bottom_s) - start,
        e.impacts.len()
    );
}

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("strokes");
    let grand = Instrument::builtin("concert-grand").expect("built in");
    let setup = Setup { settings: Settings::new(10e-6), record_every: Some(50), ..Setup::new(END_S) };
    for (name, speed, published) in NUANCES {
        let (touch, ends) = if name == "pp" { ("led", [2.0, 20.0]) } else { ("pressed", [3.0, 3000.0]) };
        let louder = found(&grand, touch, speed, ends);
        let how = match touch {
            "led" => format!("led down within {:.0} ms", 1e3 / louder),
            _ => format!("force rising by {louder:.0} N/s"),
        };
        write(&folder, &format!("{name}-pressed"), &how, published, &play(&grand, touch, louder, &setup));
        let louder = found(&grand, "struck", speed, [0.02, 6.0]);
        let how = format!("arriving with {louder:.2} m/s");
        write(&folder, &format!("{name}-struck"), &how, published, &play(&grand, "struck", louder, &setup));
    }
}
