//! The key that lies on its balance rail, beside one that is nailed to its pin: the release, the bench test that would
//! tell them apart, and the energy of the first millimetre. Nothing is regulated again.

use moreau::{Elastoplastic, Settings};

use super::impact::tell;
use super::{Claim, Progress, ReproduceError, Section, Table};
use erard::instrument::{Bushing, Curve, Felt, Instrument, Zone};
use erard::player;
use erard::run::{Setup, simulate};
use erard_workshop::validate::release::{Hump, Release, let_go};

/// Stiffness of the punching, N/m2, and its loss: 0.11 mm under 25 N, the number that the comment of the capstan's heel
/// has. Estimates.
const PUNCHING_N_PER_M2: f64 = 1.33e9;
const PUNCHING: Elastoplastic<f64> = Elastoplastic { damping: 2.6e8, eta: 0.5, slip: 0.1 };
/// The heel's stiffness in the file is that of heel and punching in series; the heel alone is stiffer by this.
const HEEL_ALONE: f64 = 1.1 / 0.51;
/// Friction along the pins, N. An estimate; new bushings can hold a key up.
const PIN_N: f64 = 0.3;
/// Force that holds the key, N.
const HELD_N: f64 = 12.0;
/// Forces of the energy budget, N.
const HOLDS_N: [f64; 4] = [5.0, 12.0, 25.0, 40.0];
/// Weights of the bench test, kg, and their height above the balance pin, m: on top of the key.
const LEADS_KG: [f64; 4] = [0.0, 0.05, 0.1, 0.2];
const LEAD_HEIGHT_M: f64 = 0.03;
/// Step of the energy budget, s; instants of release and end.
const STEP_S: f64 = 25e-6;
const HELD_S: f64 = 0.4;
const GONE_S: f64 = 2e-3;
const END_S: f64 = 0.5;
/// Way of the key's front from the held position over which its energy is looked at, m.
const FIRST_M: f64 = 1e-3;

/// How a key lies.
#[derive(Clone, Copy)]
struct Lying {
    n_per_m2: f64,
    loss: Elastoplastic<f64>,
    pin_n: f64,
    heel: f64,
}

const USUAL: Lying = Lying { n_per_m2: PUNCHING_N_PER_M2, loss: PUNCHING, pin_n: PIN_N, heel: HEEL_ALONE };

impl Lying {
    /// Returns the instrument with its key on a punching, which is compressed as drawn by what it bears at rest.
    fn key(self, nailed: &Instrument) -> Result<Instrument, ReproduceError> {
        let missing = |what: &str| ReproduceError::Instrument(format!("the instrument has no {what}"));
        let key = nailed.roles.key.ok_or_else(|| missing("key"))?;
        let back = nailed.first_piece(key)?;
        let heel = nailed.zones.iter().position(|zone| zone.name == "capstan_heel");
        let heel = heel.ok_or_else(|| missing("zone `capstan_heel`"))?;
        let [x, y] = nailed.bodies[back].pivot_m;
        let drawn = |compressed_m: f64| -> Result<Instrument, ReproduceError> {
            let mut other = nailed.clone();
            other.edit(|fields| {
                fields.zones[heel].felt.stiffness *= self.heel;
                fields.zones.push(Zone {
                    name: "balance_rail".into(),
                    label: "key - balance-rail punching".into(),
                    disc_body: Some(back),
                    disc_center_m: [0.0; 2],
                    disc_radius_m: 0.0,
                    curve_body: None,
                    curve: Curve::Line { point_m: [x, y + compressed_m], normal: [0.0, 1.0] },
                    felt: Felt {
                        stiffness: self.n_per_m2,
                        exponent: 2.0,
                        loss: self.loss.into(),
                        thickness_m: Some(3e-3),
                    },
                    friction_coefficient: 0.0,
                    dwell: None,
                });
            })?;
            Ok(other.with_bushing(back, Bushing::Pin { friction_n: self.pin_n })?)
        };
        // Drawn without compression it sinks by what it bears, which is the compression.
        let sunk = drawn(0.0)?;
        let setup = Setup { settings: Settings::new(STEP_S), ..Setup::new(10.0 * STEP_S) };
        let run = simulate(&sunk, &player::force(|_| 0.0), &setup, &mut |_| true)?;
        drawn(-run.lifts[0].lift_m[0])
    }
}

fn mm(length_m: f64) -> String {
    format!("{:.2}", 1e3 * length_m)
}

fn or_dash(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.digits$}"))
}

/// Humps as `0.35 at 9.1`.
fn told(humps: &[Hump]) -> String {
    let told: Vec<String> = humps.iter().map(|h| format!("{} at {:.1}", mm(h.height_m), 1e3 * h.top_s)).collect();
    if told.is_empty() { "none".into() } else { told.join(", ") }
}

fn released(instrument: &Instrument, held_n: f64) -> Result<Release, ReproduceError> {
    let_go(instrument, held_n, &mut |_| true).map_err(|error| ReproduceError::Instrument(error.to_string()))
}

/// With lead upon the key, exactly above its pivot.
fn laden(instrument: &Instrument, lead_kg: f64) -> Result<Instrument, ReproduceError> {
    let mut other = instrument.clone();
    let key = instrument.roles.key.unwrap_or(0);
    let back = instrument.first_piece(key)?;
    other.edit(|fields| {
        let body = &mut fields.bodies[back];
        let whole_kg = body.mass_kg + lead_kg;
        let [x, y] = body.center_of_mass_m;
        body.center_of_mass_m = [body.mass_kg * x / whole_kg, (body.mass_kg * y + lead_kg * LEAD_HEIGHT_M) / whole_kg];
        body.inertia_kg_m2 += lead_kg * LEAD_HEIGHT_M * LEAD_HEIGHT_M;
        body.mass_kg = whole_kg;
    })?;
    Ok(other)
}

/// Energies of a key that is let go, J, and its speed, m/s, when its front has risen by [`FIRST_M`].
struct Budget {
    /// Taken by the front punching as the key went down, and given back.
    taken_j: f64,
    given_j: f64,
    /// Taken by the finger while its force vanished.
    finger_j: f64,
    /// Kinetic energy of the key about its pivot.
    key_j: f64,
    speed_m_per_s: f64,
}

fn budget(instrument: &Instrument, held_n: f64) -> Result<Budget, ReproduceError> {
    // Pressed slowly, so that the punching takes what statics says and the hammer is caught or falls as it may.
    let force = |t: f64| held_n * (t / 0.2).min(1.0) * (1.0 - (t - HELD_S) / GONE_S).clamp(0.0, 1.0);
    let setup = Setup { settings: Settings::new(STEP_S), record_every: Some(1), ..Setup::new(END_S) };
    let run = simulate(instrument, &player::force(force), &setup, &mut |_| true)?;
    let held = run.time_s.partition_point(|&t| t < HELD_S);
    let until = held + run.key_m[held..].iter().position(|y| *y < run.key_m[held] - FIRST_M).unwrap_or(0);
    let bottom = instrument.roles.key_bottom.unwrap_or(0);
    let work = |force: &[f64], from: usize, to: usize| {
        (from..to).map(|row| 0.5 * (force[row] + force[row + 1]) * (run.key_m[row + 1] - run.key_m[row])).sum::<f64>()
    };
    let punching = &run.zones[bottom].normal_n;
    let arm_m = instrument.roles.key_front_m[0];
    let key = instrument.roles.key.unwrap_or(0);
    let turn = run.bodies[key].rate_rad_per_s[until];
    let pieces = (0..instrument.bodies.len()).filter(|&body| instrument.is_same_part(body, key).unwrap_or(false));
    let inertia: f64 = pieces.map(|body| instrument.bodies[body].inertia_kg_m2).sum();
    Ok(Budget {
        taken_j: work(punching, 0, held),
        given_j: -work(punching, held, until),
        finger_j: -work(&run.force_n, held, until),
        key_j: 0.5 * inertia * turn * turn,
        speed_m_per_s: (arm_m * turn).abs(),
    })
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let mut releases = Table::new(
        format!(
            "The key is held with {HELD_N} N and let go within 2 ms; travel of its back as at the front, from its landing"
        ),
        &["key", "humps (mm at ms)", "home (ms)", "9 to 4 mm (m/s)", "largest lift (mm)"],
    );
    let stiff = |factor: f64| Lying { n_per_m2: factor * PUNCHING_N_PER_M2, ..USUAL };
    let lossless = Elastoplastic { damping: 0.0, eta: 0.0, slip: 0.1 };
    let cases: [(&str, Option<Lying>); 9] = [
        ("nailed to its pin, as in the file", None),
        ("lying on its punching", Some(USUAL)),
        ("the same, heel as in the file", Some(Lying { heel: 1.0, ..USUAL })),
        ("no friction on the pins", Some(Lying { pin_n: 0.0, ..USUAL })),
        ("friction 0.1 N", Some(Lying { pin_n: 0.1, ..USUAL })),
        ("friction 1 N", Some(Lying { pin_n: 1.0, ..USUAL })),
        ("punching of half the stiffness, as on a rail that yields", Some(stiff(0.5))),
        ("punching of twice the stiffness", Some(stiff(2.0))),
        ("punching without loss", Some(Lying { loss: lossless, ..USUAL })),
    ];
    let steps = (cases.len() + LEADS_KG.len() + HOLDS_N.len()) as f64;
    let mut done = 0.0;
    let mut next = |progress: &mut Progress| {
        done += 1.0;
        tell(progress, done / steps)
    };
    let mut found = Vec::new();
    for (name, lying) in cases {
        next(progress)?;
        let instrument = lying.map_or_else(|| Ok(instrument.clone()), |lying| lying.key(instrument))?;
        let release = released(&instrument, HELD_N)?;
        releases.row([
            name.into(),
            told(release.humps.as_deref().unwrap_or_default()),
            or_dash(release.home_s.map(|s| 1e3 * s), 1),
            or_dash(release.speed_m_per_s, 3),
            or_dash(release.lift_m.map(|m| 1e3 * m), 2),
        ]);
        found.push(release);
    }
    let mut bench = Table::new(
        "A test for a bench: lead exactly above the balance pin, largest return of a key that slips (mm). The nailed \
         key's does not change, the lying key's grows"
            .to_owned(),
        &["lead (g)", "nailed", "lying"],
    );
    let lying = USUAL.key(instrument)?;
    let mut returns = Vec::new();
    for lead_kg in LEADS_KG {
        next(progress)?;
        let of = |instrument: &Instrument| -> Result<f64, ReproduceError> {
            Ok(released(&laden(instrument, lead_kg)?, HELD_N)?.rebound_m.unwrap_or(0.0))
        };
        let pair = [of(instrument)?, of(&lying)?];
        bench.row([format!("{:.0}", 1e3 * lead_kg), mm(pair[0]), mm(pair[1])]);
        returns.push(pair);
    }
    let mut energies = Table::new(
        format!("Energies when the front of the lying key has risen by {} mm (mJ)", 1e3 * FIRST_M),
        &["held (N)", "punching took", "gave back", "finger took", "key turns with", "front (m/s)"],
    );
    let mut fastest = 0.0_f64;
    for held_n in HOLDS_N {
        next(progress)?;
        let of = budget(&lying, held_n)?;
        let mj = |energy_j: f64| format!("{:.2}", 1e3 * energy_j);
        fastest = fastest.max(of.speed_m_per_s);
        energies.row([
            format!("{held_n}"),
            mj(of.taken_j),
            mj(of.given_j),
            mj(of.finger_j),
            mj(of.key_j),
            format!("{:.3}", of.speed_m_per_s),
        ]);
    }
    let height = |release: &Release| release.rebound_m.unwrap_or(0.0);
    let claims = vec![
        Claim::new(
            "this program",
            "a key that lies on its rail comes back by less than one that is nailed to its pin",
            format!("{} mm for {} mm", mm(height(&found[1])), mm(height(&found[0]))),
            height(&found[1]) < height(&found[0]),
        ),
        Claim::new(
            "this program",
            "lead above the balance pin makes a lying key come back further, and changes a nailed one by less than 0.1 mm",
            format!(
                "{} to {} mm; nailed {} to {}",
                mm(returns[0][1]),
                mm(returns[3][1]),
                mm(returns[0][0]),
                mm(returns[3][0])
            ),
            returns[3][1] > returns[0][1] && (returns[3][0] - returns[0][0]).abs() < 0.1e-3,
        ),
        Claim::new(
            "recordings (Kawai KG-3C)",
            "a key let go rises with 0.35 m/s within its first millimetre",
            format!("{fastest:.3} m/s at the most of {} to {} N", HOLDS_N[0], HOLDS_N[3]),
            fastest >= 0.35,
        ),
    ];
    Ok(Section {
        text: vec![
            "A key is free upward: nothing but its weight, and what stands on it, holds it on the punching of the balance \
             rail. When its back meets the cloth, 268 mm behind its centre of mass, it turns about that cloth, and its \
             balance hole rises. The file's heel is that of heel and punching in series; where the key lies, the heel \
             has its own stiffness."
                .to_owned(),
        ],
        claims,
        tables: vec![releases, bench, energies],
        ..Section::default()
    })
}
