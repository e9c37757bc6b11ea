//! Blows over the compass of the keyboard with strings, from soft to loud: how long the hammer touches its strings, in how many pulses, how hard it presses, and what
//! it takes with it. The table in the book's chapter on strings.
//!
//! `cargo run --release -p erard --example blows_over_the_compass`

use erard::keyboard::{Keyboard, note_name};
use erard::{Action, Input};

/// Keys: A0, C2, C4, C6, C8.
const KEYS: [usize; 5] = [1, 16, 40, 64, 88];
/// Constant forces on the key, N: pp to ff.
const FORCES_N: [f64; 5] = [0.8, 2.0, 4.0, 8.0, 18.0];

struct Blow {
    speed_m_s: f64,
    contact_s: f64,
    pulses: u32,
    peak_n: f64,
    back_m_s: f64,
}

/// The first blow under a constant force; contacts of the next 10 ms belong to it.
fn blow(action: &mut Action, force_n: f64) -> Option<Blow> {
    let h = action.settings().step;
    let (mut first, mut blow, mut touching) = (None, None, false);
    for n in 0..(0.5 / h) as usize {
        let reading = action.step(Input::Force(force_n));
        if let (Some(strike), None) = (action.blow(), first) {
            first = Some(n);
            blow = Some(Blow { speed_m_s: strike.speed_m_s, contact_s: 0.0, pulses: 0, peak_n: 0.0, back_m_s: 0.0 });
        }
        let (Some(since), Some(blow)) = (first, &mut blow) else { continue };
        if (n - since) as f64 * h > 10e-3 {
            break;
        }
        if reading.string_n > 0.0 {
            blow.pulses += u32::from(!touching);
            (blow.contact_s, blow.back_m_s) = ((n - since + 1) as f64 * h, -reading.hammer_m_s);
            blow.peak_n = blow.peak_n.max(reading.string_n);
        }
        touching = reading.string_n > 0.0;
    }
    blow
}

fn main() {
    let keyboard = Keyboard::builtin("concert-grand-strings").expect("built in");
    println!("key  force N  hammer m/s  contact ms  pulses  peak N  back m/s  (of the speed)");
    for key in KEYS {
        let instrument = keyboard.key(key).expect("it reads");
        for force_n in FORCES_N {
            let mut action = Action::new(&instrument).expect("it comes to rest");
            let Some(b) = blow(&mut action, force_n) else {
                println!("{:<4} {force_n:>7}  does not sound", note_name(key));
                continue;
            };
            println!(
                "{:<4} {force_n:>7}  {:>10.2}  {:>10.2}  {:>6}  {:>6.1}  {:>8.2}  ({:.2})",
                note_name(key),
                b.speed_m_s,
                b.contact_s * 1e3,
                b.pulses,
                b.peak_n,
                b.back_m_s,
                b.back_m_s / b.speed_m_s
            );
        }
    }
}
