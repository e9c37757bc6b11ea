//! The released key comes up and rebounds from its back-rail cloth. The cases separate the effects of the finger's
//! leaving, the cloth, the key that is heavier in front while the hammer still falls, and the key's front that swings
//! on when its back has stopped. `landing.rs` compares recorded releases.

use moreau::Settings;

use super::felt_losses::{ETA, SLIP, restitution};
use super::gives::stiffen;
use super::humps;
use super::impact::tell;
use super::landing;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table, bending};
use erard::instrument::Instrument;
use erard::run::Setup;
use erard::run::press_by_hand;
use erard::stroke::{HandStroke, Muscle};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// Force of the hold, N, and times of release and end, s.
const HOLD_N: f64 = 4.0;
const LET_GO_S: f64 = 0.4;
const END_S: f64 = 0.9;
/// Distance from rest at which a key is up, m; one that then falls below twice that rebounds.
const UP_M: f64 = 0.1e-3;
/// Number of cases in the picture; the others are in the table only.
const SHOWN: usize = 9;
/// Losses of the cloth, compared with b, eta and s of the elastoplastic felt: those of `felt-losses`, and one that
/// returns little.
const LOSSES: [[f64; 2]; 2] = [[ETA, SLIP], [0.9, 0.02]];

/// One way of releasing a key.
struct Case {
    name: &'static str,
    instrument: Instrument,
    touch: HandStroke,
    colour: usize,
    mark: Dash,
}

/// Motion of key and hammer.
pub(super) struct Released {
    pub time_s: Vec<f64>,
    pub key_m: Vec<f64>,
    pub head_m: Vec<f64>,
}

impl Released {
    fn new(case: &Case) -> Result<Self, ReproduceError> {
        let setup = Setup { settings: Settings::new(STEP_S), record_every: Some(4), ..Setup::new(END_S) };
        let run = press_by_hand(&case.instrument, &case.touch, &setup, &mut |_| true)?;
        let from = run.time_s.partition_point(|&t| t < LET_GO_S);
        let [time_s, key_m, head_m] = [&run.time_s, &run.key_m, &run.hammer_rise_m].map(|all| all[from..].to_vec());
        Ok(Released { time_s, key_m, head_m })
    }

    /// Time at which the key is first up, s after the release.
    fn up_s(&self) -> Option<f64> {
        self.key_m.iter().position(|&y| y < UP_M).map(|row| self.time_s[row] - LET_GO_S)
    }

    /// Depths of all recorded rebounds after it was up, m.
    fn rebounds_m(&self) -> Vec<f64> {
        let first = self.key_m.iter().position(|&y| y < UP_M).unwrap_or(self.key_m.len());
        let (mut rebounds, mut deepest) = (Vec::new(), 0.0_f64);
        for &y in &self.key_m[first..] {
            deepest = deepest.max(y);
            if y < UP_M && deepest > 2.0 * UP_M {
                rebounds.push(deepest);
                deepest = 0.0;
            }
        }
        rebounds
    }
}

/// The same key, balanced: the mass of its front moved toward the pin, which its moment of inertia there allows.
fn balanced(instrument: &Instrument) -> Option<Instrument> {
    let key = instrument.roles.key?;
    let moment = |i: &Instrument| -> f64 {
        let is_piece = |body: usize| i.is_same_part(body, key) == Ok(true) && !i.is_arm(body);
        let pieces = i.bodies.iter().enumerate().filter(|(body, _)| is_piece(*body));
        let placed = pieces.filter_map(|(body, own)| Some((own, i.on_first_piece(body).ok()?)));
        placed.map(|(own, place)| own.mass_kg * place.to_world(own.center_of_mass_m)[0]).sum()
    };
    let mut other = instrument.clone();
    let mass_kg = other.bodies[key].mass_kg;
    other.edit(|fields| fields.bodies[key].center_of_mass_m[0] -= moment(instrument) / mass_kg).expect("numbers alone");
    Some(other)
}

fn lossy(instrument: &Instrument, [eta, slip]: [f64; 2]) -> Instrument {
    let mut other = instrument.clone();
    other
        .edit(|fields| {
            for zone in fields.zones.iter_mut().filter(|zone| zone.name == "key_back_rail") {
                let damping = zone.felt.loss.viscous(1.0, 0.0);
                zone.felt.loss = moreau::Elastoplastic { damping, eta, slip }.into();
            }
        })
        .expect("numbers alone");
    other
}

/// A softer cloth that returns less.
fn softer(instrument: &Instrument) -> Instrument {
    let mut other = instrument.clone();
    other
        .edit(|fields| {
            for zone in fields.zones.iter_mut().filter(|zone| zone.name == "key_back_rail") {
                zone.felt.stiffness *= 0.1;
                if let moreau::Loss::Iwan(law) = &mut zone.felt.loss {
                    law.damping *= 3.0;
                }
            }
        })
        .expect("numbers alone");
    other
}

/// A key whose bend loses more than wood does, as with cloth under the balance rail.
fn dull(instrument: &Instrument) -> Instrument {
    let mut other = instrument.clone();
    other
        .edit(|fields| {
            for body in fields.bodies.iter_mut().filter(|body| body.is_bend && body.name == "key") {
                body.viscous_n_m_s *= 20.0;
            }
        })
        .expect("numbers alone");
    other
}

/// A key that sticks in its pins.
fn rubbing(instrument: &Instrument) -> Instrument {
    let mut other = instrument.clone();
    if let Some(back) = instrument.roles.key.and_then(|key| instrument.first_piece(key).ok()) {
        other.edit(|fields| fields.bodies[back].friction_torque_n_m *= 3.0).expect("numbers alone");
    }
    other
}

fn curve(case: &Case, released: &Released) -> ChartCurve {
    ChartCurve {
        label: case.name.into(),
        x: released.time_s.iter().map(|t| 1e3 * (t - LET_GO_S)).collect(),
        y: released.key_m.iter().map(|y| 1e3 * y).collect(),
        colour: case.colour,
        mark: case.mark,
    }
}

pub(super) fn section(asked: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let grand = bending(asked)?;
    let Some(even) = balanced(&grand) else { return Err(ReproduceError::Instrument("there is no key".into())) };
    let mut stiff = even.clone();
    stiffen(&mut stiff, grand.roles.key);
    let held = HandStroke { muscle: Muscle::Steady { force_n: HOLD_N }, ..HandStroke::ramped(1.0) };
    let [at_once, usual] = [1e-3, 0.030].map(|within_s| held.leaving(LET_GO_S, within_s));
    // A led hand goes up within twice the time.
    let [led, slowly] = [0.060, 0.120].map(|within_s| HandStroke::led(0.2).leaving(LET_GO_S, within_s));
    let case = |name, instrument: &Instrument, touch, colour, mark| Case {
        name,
        instrument: instrument.clone(),
        touch,
        colour,
        mark,
    };
    let cases = [
        case("force gone at once (1 ms)", &grand, at_once, 0, Dash::Solid),
        case("force gone within 30 ms", &grand, usual, 1, Dash::Solid),
        case("led up within 120 ms", &grand, led, 2, Dash::Solid),
        case("led up within 240 ms", &grand, slowly, 3, Dash::Solid),
        case("30 ms, cloth with a loss", &lossy(&grand, LOSSES[0]), usual, 4, Dash::Dashed),
        case("30 ms, cloth with a great loss", &lossy(&grand, LOSSES[1]), usual, 5, Dash::Dashed),
        case("30 ms, even key", &even, usual, 6, Dash::Dotted),
        case("30 ms, great loss and even key", &lossy(&even, LOSSES[1]), usual, 7, Dash::Dotted),
        case("30 ms, great loss, even key that does not bend", &lossy(&stiff, LOSSES[1]), usual, 0, Dash::Dotted),
        // In the table only.
        case("30 ms, cloth k x 0.1, b x 3", &softer(&grand), usual, 0, Dash::Solid),
        case("30 ms, loss of the key's bend x 20", &dull(&grand), usual, 0, Dash::Solid),
        case("30 ms, great loss, loss of the bend x 20", &lossy(&dull(&grand), LOSSES[1]), usual, 0, Dash::Solid),
        case("30 ms, friction of the key's pin x 3", &rubbing(&grand), usual, 0, Dash::Solid),
    ];
    let mut table = Table::new("The key after it is let go", &["how", "up after (ms)", "rebounds (mm)"]);
    let (mut curves, mut first, mut free) = (Vec::new(), Vec::new(), None);
    for (n, case) in cases.iter().enumerate() {
        tell(progress, n as f64 / cases.len() as f64)?;
        let released = Released::new(case)?;
        let rebounds = released.rebounds_m();
        let shown: Vec<String> = rebounds.iter().take(4).map(|m| format!("{:.1}", 1e3 * m)).collect();
        table.row([
            case.name.to_owned(),
            released.up_s().map_or("-".into(), |s| format!("{:.0}", 1e3 * s)),
            if shown.is_empty() { "none".into() } else { shown.join(", ") },
        ]);
        if n < SHOWN {
            curves.push(curve(case, &released));
        }
        first.push(1e3 * rebounds.first().copied().unwrap_or(0.0));
        free.get_or_insert(released);
    }
    let [at_once, usual, _, slowly, _, cloth, even, both, stiff, ..] = first[..] else { return Ok(Section::default()) };
    let mut section = Section {
        text: vec![format!(
            "The key is held with {HOLD_N} N by a hand and let go: the force is gone within the time said, and the hand leaves. A rebound is every way back down \
             by more than {:.1} mm. The cloth's own loss is the elastoplastic one beside b; by itself it gives back {:.2} of a speed, the great one {:.2}. An even key, as heavy behind as in front, is no real \
             key: it shows what its weight in front does while the hammer is in the air and presses on nothing. A key that does not bend stops at once with its back; \
             the front of one that does swings on, and back again, and lifts the back from a cloth that has taken its own motion up.",
            2e3 * UP_M,
            restitution(LOSSES[0]),
            restitution(LOSSES[1])
        )],
        claims: vec![Claim::new(
            "this program",
            "what the key comes down again is the cloth's doing, its own weight's in front and its bending's: neither a finger that leaves at its usual pace nor one or \
             two of the causes taken away make an end of it; all three, or a finger that leads the key up, do",
            format!(
                "first rebound {at_once:.1} mm when let go at once, {usual:.1} mm within 30 ms, {slowly:.1} mm led up within 240 ms; with a great loss in the cloth \
                 {cloth:.1}, with an even key {even:.1}, with both {both:.1}, and if that key does not bend {stiff:.1} mm"
            ),
            slowly < 0.5 * usual && both < cloth.min(even) && both < usual && stiff < 0.5 * both,
        )],
        tables: vec![table],
        charts: vec![Chart {
            title: "A key let go".into(),
            caption: "Travel of the key's front; 0 ms: the hand begins to leave".into(),
            x_label: "time (ms)".into(),
            x_log: false,
            panels: vec![ChartPanel { y_label: "key front, down (mm)".into(), y_log: false, y_range: None, curves }],
        }],
        ..Section::default()
    };
    if let Some(free) = &free {
        landing::add(&grand, free, &mut section);
    }
    humps::add(&grand, &mut section)?;
    Ok(section)
}
