//! Compliance in a loud note: deflection of key, shank, heel and knuckle over time, and the effect of each on timing.

use moreau::Settings;

use super::impact::tell;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table, bending, builtin};
use erard::grand::Anatomy;
use erard::instrument::{Instrument, Zone};
use erard::one_dof;
use erard::run::Run;
use erard::run::Setup;
use erard::run::press_by_hand;
use erard::stroke::HandStroke;
use erard_workshop::validate::{Loudness, loudness};

/// Value of a row, in the unit that ends its name.
type Value = fn(&Loudness) -> Option<f64>;

/// Step, s.
const STEP_S: f64 = 50e-6;
/// Rate of force of the pressed f, N/s: the built-in f's.
const RATE_N_S: f64 = 333.0;
/// Window shown before and after the impact, s.
const WINDOW_S: [f64; 2] = [0.040, 0.008];
/// Factor by which a bend is stiffened, so that it bends by a micrometre.
const LOCKED: f64 = 1e3;
const MM_PER_M: f64 = 1e3;
const MS_PER_S: f64 = 1e3;

pub(super) fn section(asked: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let bending = bending(asked)?;
    let rigid = builtin("concert-grand-rigid")?;
    let mut section = Section {
        text: vec![
            "A pressed f: a hand of 0.2 kg whose force rises by 333 N/s. How far each part yields is referred to the key's front, where a millimetre is a \
             millimetre of the finger: the bends by the angle of their hinges, heel and knuckle by the compression that their force needs at rest, divided by \
             the leverage up to them."
                .into(),
            "The table plays the rows of `erard validate` on the order of events. Between its columns one thing changes at a time and nothing is \
             regulated again: bends that are not meant are a thousand times stiffer, and the felts are the rigid grand's but in the last."
                .into(),
        ],
        ..Section::default()
    };
    tell(progress, 0.02)?;
    section.charts.push(chart(&bending)?);

    let mut key = bending.clone();
    stiffen(&mut key, bending.roles.hammer);
    let (mut shank, mut both) = (bending.clone(), bending.clone());
    stiffen(&mut shank, bending.roles.key);
    let mut stiff = key.clone();
    stiffen(&mut stiff, bending.roles.key);
    for name in ["capstan_heel", "key_front"] {
        let of = |i: &Instrument| i.zones.iter().position(|zone| zone.name == name);
        if let (Some(a), Some(b)) = (of(&bending), of(&rigid)) {
            for one in [&mut stiff, &mut key, &mut shank, &mut both] {
                one.edit(|fields| fields.zones[a].felt = rigid.zones[b].felt).expect("numbers alone");
            }
        }
    }
    let columns = [
        ("nothing bends", &stiff),
        ("shank bends", &shank),
        ("key bends", &key),
        ("key and shank bend", &both),
        ("and felts toward their start set", &bending),
    ];
    let mut found = Vec::new();
    for (n, (_, instrument)) in columns.iter().enumerate() {
        let part = |share: f64| 0.05 + 0.95 * (n as f64 + share) / columns.len() as f64;
        found.push(loudness(instrument, &mut |share| progress(part(share))).map_err(|error| match error {
            erard_workshop::measure::MeasureError::Simulation(error) => ReproduceError::Simulation(error),
            other => ReproduceError::Instrument(other.to_string()),
        })?);
    }
    let mut header = vec!["row of `erard validate`"];
    header.extend(columns.iter().map(|(name, _)| *name));
    let mut table = Table::new("What each part does to the order of events", &header);
    let rows: [(&str, Value); 7] = [
        ("pressed f: hammer before key bottom, ms", |l| ms(l.by_hand.f_by_stroke?.hammer_ahead_s)),
        ("pressed ff, ms", |l| ms(l.by_hand.ff?.hammer_ahead_s)),
        ("pressed, loudest, ms", |l| ms(l.by_hand.loudest.hammer_ahead_s)),
        ("pressed: come together at, m/s", |l| l.by_hand.crossover_m_per_s),
        ("led, pp, ms", |l| ms(l.by_hand.pp?.hammer_ahead_s)),
        ("constant force, key stroke of 25 ms, ms", |l| ms(l.f_by_stroke?.hammer_ahead_s)),
        ("constant force: come together at, m/s", |l| l.crossover_m_per_s),
    ];
    for (name, value) in rows {
        let cells = found.iter().map(|one| value(one).map_or_else(|| "-".into(), |x| format!("{x:.2}")));
        table.row(std::iter::once(name.to_owned()).chain(cells));
    }
    section.tables.push(table);
    let f = |l: &Loudness| l.by_hand.f_by_stroke.and_then(|b| b.hammer_ahead_s).unwrap_or(f64::NAN) * MS_PER_S;
    let [by_shank, by_key] = [1, 2].map(|n| f(&found[n]) - f(&found[0]));
    section.claims.push(Claim::new(
        "this program",
        "it is the key: its bending moves the pressed f by more than a millisecond, the shank's by less than a third of that",
        format!("key {by_key:.2} ms, shank {by_shank:.2} ms"),
        by_key < -1.0 && by_shank.abs() < by_key.abs() / 3.0,
    ));
    Ok(section)
}

fn ms(seconds: Option<f64>) -> Option<f64> {
    seconds.map(|s| s * MS_PER_S)
}

/// Stiffens the bends of a part so much that they have no effect.
pub(super) fn stiffen(instrument: &mut Instrument, piece: Option<usize>) {
    let Some(piece) = piece else { return };
    instrument
        .edit(|fields| {
            for spring in &mut fields.springs {
                if spring.body == piece && fields.bodies[piece].is_bend {
                    spring.stiffness_n_m_per_rad *= LOCKED;
                }
            }
        })
        .expect("numbers alone");
}

/// Deflection of each part, stacked.
fn chart(instrument: &Instrument) -> Result<Chart, ReproduceError> {
    let setup = Setup { settings: Settings::new(STEP_S), record_every: Some(1), ..Setup::new(0.12) };
    let run = press_by_hand(instrument, &HandStroke::ramped(RATE_N_S), &setup, &mut |_| true)?;
    let Some(contact_s) = run.events.hammer_contact_s() else {
        return Err(ReproduceError::Instrument("the pressed f does not sound".into()));
    };
    let from = run.time_s.partition_point(|&t| t < contact_s - WINDOW_S[0]);
    let to = run.time_s.partition_point(|&t| t < contact_s + WINDOW_S[1]);
    let x: Vec<f64> = run.time_s[from..to].iter().map(|t| (t - contact_s) * MS_PER_S).collect();
    let mut below = vec![0.0; x.len()];
    let mut curves = Vec::new();
    for (colour, (label, give_m)) in parts(instrument, &run)?.into_iter().enumerate() {
        for (sum, give) in below.iter_mut().zip(&give_m[from..to]) {
            *sum += give * MM_PER_M;
        }
        let label = if colour == 0 { label.to_owned() } else { format!("+ {label}") };
        curves.push(ChartCurve { label, x: x.clone(), y: below.clone(), colour: colour + 1, mark: Dash::Solid });
    }
    let travel: Vec<f64> = run.force_n[from..to].to_vec();
    let force = ChartCurve { label: "finger's force".into(), x, y: travel, colour: 0, mark: Dash::Solid };
    Ok(Chart {
        title: "What gives in a pressed f".into(),
        caption: "Millimetres at the key's front, one above the other; 0 ms: the hammer meets the string".into(),
        x_label: "time before and after the impact (ms)".into(),
        x_log: false,
        panels: vec![
            ChartPanel { y_label: "give at the key's front (mm)".into(), y_log: false, y_range: None, curves },
            ChartPanel { y_label: "force (N)".into(), y_log: false, y_range: None, curves: vec![force] },
        ],
    })
}

/// Deflections from the finger up, m at the key's front, in every row of the run.
fn parts(instrument: &Instrument, run: &Run) -> Result<Vec<(&'static str, Vec<f64>)>, ReproduceError> {
    let anatomy = Anatomy::find(instrument).map_err(|e| ReproduceError::Instrument(e.to_string()))?;
    let one = one_dof::reduce(instrument)?;
    let rigid = instrument.locked();
    let length = |[x, y]: [f64; 2]| x.hypot(y);
    let front_m = length(rigid.roles.key_front_m);
    let Some(hammer) = rigid.roles.hammer else { return Ok(Vec::new()) };
    // Metres there per metre of the key's front.
    let head = one.ratios[hammer].abs() * length(rigid.roles.hammer_strike_point_m) / front_m;
    let knuckle = one.ratios[hammer].abs() * length(rigid.zones[anatomy.jack_knuckle].disc_center_m) / front_m;
    // A negative arm: the piece lags behind.
    let bend = |piece: usize, arm_m: f64, lever: f64| -> Vec<f64> {
        let Some(parent) = instrument.bodies[piece].parent.filter(|_| instrument.bodies[piece].is_bend) else {
            return vec![0.0; run.time_s.len()];
        };
        let angle = |row: usize| run.bodies[piece].angle_rad[row] - run.bodies[parent].angle_rad[row];
        (0..run.time_s.len()).map(|row| (angle(row) - angle(0)) * arm_m / lever).collect()
    };
    let felt = |zone: &Zone, normal: &[f64], lever: f64| -> Vec<f64> {
        let at = |force: f64| (force / zone.felt.stiffness).powf(1.0 / zone.felt.exponent) / lever;
        normal.iter().map(|&force| at(force) - at(normal[0])).collect()
    };
    let heel = instrument.zones.iter().position(|zone| zone.name == "capstan_heel");
    let (key, hammer_piece) = (anatomy.key, anatomy.hammer);
    let head_arm_m = length(instrument.roles.hammer_strike_point_m);
    let mut all = vec![("key", bend(key, length(instrument.roles.key_front_m), 1.0))];
    if let Some(heel) = heel {
        let arm = length(rigid.zones[heel].disc_center_m) / front_m;
        all.push(("heel felt", felt(&instrument.zones[heel], &run.zones[heel].normal_n, arm)));
    }
    let zone = anatomy.jack_knuckle;
    all.push(("knuckle", felt(&instrument.zones[zone], &run.zones[zone].normal_n, knuckle)));
    all.push(("shank", bend(hammer_piece, -head_arm_m, head)));
    Ok(all)
}
