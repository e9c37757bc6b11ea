//! Stiffness and loss of heel and knuckle: recorded strokes of a real action, and the published order of events, over
//! both.
//!
//! The recorded key drives the model's, as in `compare`, where it was measured: behind the balance pin. All these
//! strokes choose (`recordings/split.csv`); none of them judges.

use moreau::{Loss, Settings};

use super::impact::tell;
use super::{Claim, Progress, ReproduceError, Section, Table, bending, builtin};
use erard::instrument::Instrument;
use erard::recording::{LowPass, Preparation, prepare};
use erard::run::{Setup, SimulationError};
use erard::stroke::{Columns, PositionOf, Prescribed, Recording, Series};
use erard_workshop::compare::{Choice, Which, compare_chosen};
use erard_workshop::distances::{self, Protocol};
use erard_workshop::regulate::{Goal, Specification, Status, regulate};
use erard_workshop::validate::{Published, PublishedRow, Verdict, loudness};

/// Felts of the train between key and hammer.
const TRAIN: [&str; 3] = ["capstan_heel", "jack_knuckle", "lever_knuckle"];
/// Stiffness under load over the start set's: the built-in one, and the cases.
const BUILT_IN: f64 = 0.65;
const SHARES: [f64; 6] = [0.3, 0.4, 0.5, BUILT_IN, 0.8, 1.0];
/// Factors of b, and of the sliders' loss (`iwan_loss`), at the built-in stiffness.
const LOSSES: [[f64; 2]; 4] = [[0.5, 1.0], [2.0, 1.0], [1.0, 0.5], [1.0, 1.5]];
/// Regulation of the recorded action, m, and the instrument with about its leverage.
const RECORDED: [(Goal, f64); 5] =
    [(Goal::Blow, 50.8e-3), (Goal::Dip, 11.7e-3), (Goal::LetOff, 3.8e-3), (Goal::Drop, 2.2e-3), (Goal::Check, 18e-3)];
const RECORDED_AS: &str = "steinway-o";
/// Goals that keep their values while the felts change.
const KEPT: [Goal; 7] =
    [Goal::Dip, Goal::Blow, Goal::JackPosition, Goal::LeverHeight, Goal::LetOff, Goal::Drop, Goal::Check];
/// Above this the recordings hold more noise than motion, Hz.
const LOW_PASS_HZ: f64 = 250.0;
/// Hammer's way over which its speed is measured, m: the recorded blow is 50.8 mm.
const WAY_M: [f64; 2] = [10e-3, 45e-3];
/// Parts of it, m.
const PARTS_M: [[f64; 2]; 3] = [[12e-3, 24e-3], [24e-3, 36e-3], [36e-3, 45e-3]];
/// Recorded strokes, the medium one first; the others were struck.
pub(super) const STROKES: [(&str, &str); 6] = [
    ("medium", include_str!("../../../../crates/erard-core/recordings/kawai-kg-3c-medium.csv")),
    ("fast", include_str!("../../../../crates/erard-core/recordings/kawai-kg-3c-fast.csv")),
    ("struck-1", include_str!("../../../../crates/erard-core/recordings/kawai-kg-3c-struck-1.csv")),
    ("struck-2", include_str!("../../../../crates/erard-core/recordings/kawai-kg-3c-struck-2.csv")),
    ("struck-3", include_str!("../../../../crates/erard-core/recordings/kawai-kg-3c-struck-3.csv")),
    ("struck-4", include_str!("../../../../crates/erard-core/recordings/kawai-kg-3c-struck-4.csv")),
];
/// Rows of `erard validate` on the order of events under hands that press.
const ORDER: [&str; 4] = ["hammer_ahead_f", "hammer_ahead_ff", "hammer_ahead_loudest", "crossover"];

/// Change of the felts.
#[derive(Clone, Copy)]
struct Case {
    stiffness: f64,
    damping: f64,
    eta: f64,
}

impl Case {
    fn name(self) -> String {
        let factor =
            |name: &str, factor: f64| if factor == 1.0 { String::new() } else { format!(", {name} x {factor}") };
        let [damping, eta] = [factor("b", self.damping), factor("loss", self.eta)];
        format!("{:.2}{damping}{eta}", self.stiffness)
    }

    /// The instrument with these felts, regulated to the same distances.
    fn of(
        self,
        instrument: &Instrument,
        goals: &Specification,
        progress: &mut Progress,
    ) -> Result<Instrument, ReproduceError> {
        let mut changed = instrument.clone();
        changed
            .edit(|fields| {
                for zone in fields.zones.iter_mut().filter(|zone| TRAIN.contains(&zone.name.as_str())) {
                    let Loss::Iwan(law) = &mut zone.felt.loss else { continue };
                    let before = 1.0 + law.eta;
                    law.damping *= self.damping;
                    law.eta *= self.eta;
                    // The curve under load stays.
                    zone.felt.stiffness *= self.stiffness / BUILT_IN * before / (1.0 + law.eta);
                }
            })
            .expect("numbers alone");
        let mut going = |status: &Status| progress(status.share);
        Ok(regulate(&changed, goals, &Protocol::default(), &mut going).map_err(failed)?.instrument)
    }
}

fn failed(error: impl std::fmt::Display) -> ReproduceError {
    ReproduceError::Instrument(error.to_string())
}

/// Simulated hammer beside a recorded one.
struct Beside {
    /// Time by which it is late at the end of the way, s.
    late_s: f64,
    /// Its speed over the recorded one's.
    speed: f64,
    /// The same in parts of the way.
    parts: [f64; 3],
}

impl Beside {
    fn new(instrument: &Instrument, series: &Series, position_of: PositionOf) -> Result<Self, ReproduceError> {
        let setup = Setup { settings: Settings::new(50e-6), ledger: false, ..Setup::new(1.0) };
        let (drives, models) = (vec![Prescribed::Rigid], vec![Which::Action]);
        let choice = Choice { drives, models, position_of, ..Choice::default() };
        let comparison = compare_chosen(instrument, series, &choice, &setup, &mut |_| true)?;
        let simulated = comparison.trial(Prescribed::Rigid, Which::Action).map(|trial| &trial.hammer_rise_m);
        let hammers = comparison.measured_hammer_rise_m.as_ref().zip(simulated);
        let (recorded, simulated) = hammers.ok_or_else(|| failed("a recorded stroke has no hammer"))?;
        let reaches = |hammer: &[f64], way_m: f64| {
            let row = hammer.iter().position(|at| *at >= way_m).ok_or_else(|| failed("a hammer does not rise"))?;
            let [low, high] = [hammer[row.saturating_sub(1)], hammer[row]];
            let part = if high > low { (high - way_m) / (high - low) } else { 0.0 };
            let before = comparison.time_s[row.saturating_sub(1)];
            Ok::<f64, ReproduceError>(comparison.time_s[row] - part * (comparison.time_s[row] - before))
        };
        let late_s = reaches(simulated, WAY_M[1])? - reaches(recorded, WAY_M[1])?;
        let speed = |[from_m, to_m]: [f64; 2]| {
            let took = |hammer: &[f64]| Ok::<f64, ReproduceError>(reaches(hammer, to_m)? - reaches(hammer, from_m)?);
            Ok::<f64, ReproduceError>(took(recorded)? / took(simulated)?)
        };
        let [a, b, c] = PARTS_M.map(speed);
        Ok(Beside { late_s, speed: speed(WAY_M)?, parts: [a?, b?, c?] })
    }
}

/// Result of a case.
struct Found {
    case: Case,
    beside: Vec<Beside>,
    /// Values of [`ORDER`].
    order: [Option<f64>; 4],
}

impl Found {
    fn new(
        case: Case,
        [recorded_as, grand]: [(&Instrument, &Specification); 2],
        strokes: &[Series],
        progress: &mut Progress,
    ) -> Result<Self, ReproduceError> {
        let like_the_recorded = case.of(recorded_as.0, recorded_as.1, progress)?;
        let beside = strokes.iter().map(|series| {
            tell(progress, 0.0)?;
            Beside::new(&like_the_recorded, series, PositionOf::KeyBack)
        });
        let beside = beside.collect::<Result<_, ReproduceError>>()?;
        let by_hand = loudness(&case.of(grand.0, grand.1, progress)?, progress).map_err(failed)?.by_hand;
        let ms = |ahead_s: Option<f64>| ahead_s.map(|s| 1e3 * s);
        let order = [
            ms(by_hand.f_by_stroke.and_then(|press| press.hammer_ahead_s)),
            ms(by_hand.ff.and_then(|press| press.hammer_ahead_s)),
            ms(by_hand.loudest.hammer_ahead_s),
            by_hand.crossover_m_per_s,
        ];
        Ok(Found { case, beside, order })
    }

    /// Root mean square error of the arrival, s.
    fn late_s(&self) -> f64 {
        (self.mean(|one| one.late_s * one.late_s)).sqrt()
    }

    /// Mean over the strokes.
    fn mean(&self, of: impl Fn(&Beside) -> f64) -> f64 {
        self.beside.iter().map(of).sum::<f64>() / self.beside.len() as f64
    }

    /// Number of rows met.
    fn met(&self, rows: &[&PublishedRow]) -> usize {
        let met = |row: &PublishedRow, value: Option<f64>| matches!(row.judge(value), Verdict::Met { .. });
        rows.iter().zip(self.order).filter(|(row, value)| met(row, *value)).count()
    }
}

pub(super) fn section(asked: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    tell(progress, 0.0)?;
    let grand = bending(asked)?;
    let own = distances::measure(&grand, &Protocol::default(), &mut |_| true).map_err(failed)?;
    let kept: Specification = KEPT.into_iter().filter_map(|goal| Some((goal, goal.of(&own)?))).collect();
    let (recorded_as, recorded) = (builtin(RECORDED_AS)?, RECORDED.to_vec());
    let preparation = Preparation { low_pass: LowPass::At(LOW_PASS_HZ), ..Preparation::default() };
    let mut strokes = Vec::new();
    for (name, text) in STROKES {
        let recording = Recording::read(text.as_bytes(), name, &Columns::default()).map_err(failed)?;
        strokes.push(prepare(&recording, &preparation).map_err(failed)?.series);
    }
    let stiffnesses = SHARES.map(|stiffness| Case { stiffness, damping: 1.0, eta: 1.0 });
    let losses = LOSSES.map(|[damping, eta]| Case { stiffness: BUILT_IN, damping, eta });
    let cases: Vec<Case> = stiffnesses.into_iter().chain(losses).collect();
    let mut found = Vec::new();
    for (n, case) in cases.iter().enumerate() {
        let (share, mut ended) = (n as f64 / cases.len() as f64, false);
        let of = [(&recorded_as, &recorded), (&grand, &kept)];
        let one = Found::new(*case, of, &strokes, &mut |_| {
            ended |= !progress(share);
            !ended
        });
        found.push(one.map_err(|error| if ended { SimulationError::Interrupted.into() } else { error })?);
    }
    let own = Case { stiffness: BUILT_IN, damping: 1.0, eta: 1.0 }.of(&recorded_as, &recorded, progress)?;
    let at_the_front = strokes.iter().map(|series| Beside::new(&own, series, PositionOf::Key));
    let at_the_front = at_the_front.collect::<Result<Vec<_>, _>>()?;
    let published = Published::builtin();
    let rows: Vec<&PublishedRow> =
        ORDER.iter().filter_map(|name| published.rows.iter().find(|row| row.name == *name)).collect();
    Ok(Section {
        text: vec![format!(
            "Stiffness under load of heel and both knuckles, over the start set's; the built-in grand has {BUILT_IN}. For \
             the recordings, `{RECORDED_AS}` with these felts is regulated to the recorded action's distances, and its key \
             follows the recorded one behind the balance pin, where it was measured; for the order of events the concert \
             grand keeps its own distances. b is the viscous damping, loss that of the sliders."
        )],
        claims: claims(&found, &rows),
        tables: vec![beside_the_recorded(&found), in_parts(&found, &at_the_front), order_of_events(&found, &rows)],
        ..Section::default()
    })
}

fn beside_the_recorded(found: &[Found]) -> Table {
    let mut header = vec!["stiffness under load"];
    header.extend(STROKES.iter().map(|(name, _)| *name));
    header.extend(["rms", "speed"]);
    let mut table = Table::new(
        "Hammer beside the recorded one, 45 mm up: ms late; its speed from 10 to 45 mm over the recorded one's",
        &header,
    );
    for one in found {
        let late = one.beside.iter().map(|beside| format!("{:+.1}", 1e3 * beside.late_s));
        let all = [format!("{:.1}", 1e3 * one.late_s()), format!("{:.2}", one.mean(|one| one.speed))];
        table.row(std::iter::once(one.case.name()).chain(late).chain(all));
    }
    table
}

/// Speeds in three parts of the way, over the struck strokes: mean, and half of what lies between them.
fn in_parts(found: &[Found], at_the_front: &[Beside]) -> Table {
    let parts = PARTS_M.map(|part| part.map(|m| format!("{:.0}", 1e3 * m)).join(" to ") + " mm");
    let mut table = Table::new(
        "Speed of the hammer over the recorded one's in parts of its way, five struck strokes: mean, and half of their span",
        &["stiffness under load", &parts[0], &parts[1], &parts[2]],
    );
    let mut row = |name: String, beside: &[Beside]| {
        let struck = &beside[1..];
        let cells = [0, 1, 2].map(|part| {
            let all = || struck.iter().map(|one| one.parts[part]);
            let mean = all().sum::<f64>() / struck.len() as f64;
            let [low, high] = [all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max)];
            format!("{mean:.2} +-{:.2}", 0.5 * (high - low))
        });
        table.row(std::iter::once(name).chain(cells));
    };
    for one in found {
        row(one.case.name(), &one.beside);
    }
    row(format!("{BUILT_IN:.2}, front driven"), at_the_front);
    table
}

fn order_of_events(found: &[Found], rows: &[&PublishedRow]) -> Table {
    let mut header = vec!["stiffness under load"];
    header.extend(["f (ms)", "ff (ms)", "loudest (ms)", "come together at (m/s)"]);
    let mut table = Table::new("Hammer before key bottom under hands that press", &header);
    let range = |row: &&PublishedRow| match (row.at_least, row.at_most) {
        (Some(low), Some(high)) => format!("{low} to {high}"),
        _ => row.range(),
    };
    table.row(std::iter::once("published".to_owned()).chain(rows.iter().map(range)));
    for one in found {
        let cells = one.order.iter().map(|value| value.map_or("-".into(), |value| format!("{value:.2}")));
        table.row(std::iter::once(one.case.name()).chain(cells));
    }
    table
}

fn claims(found: &[Found], rows: &[&PublishedRow]) -> Vec<Claim> {
    let (stiff, lossy) = found.split_at(SHARES.len());
    let nearest =
        stiff.iter().min_by(|a, b| a.late_s().total_cmp(&b.late_s())).map_or(f64::NAN, |one| one.case.stiffness);
    let most = stiff.iter().map(|one| one.met(rows)).max().unwrap_or_default();
    let with_most: Vec<f64> = stiff.iter().filter(|one| one.met(rows) == most).map(|one| one.case.stiffness).collect();
    let mut claims = vec![Claim::new(
        "recorded and published",
        "the recorded strokes ask for softer felts of heel and knuckle than the published order of events; the built-in ones lie between",
        format!(
            "the arrivals are nearest at {nearest:.2} of the start set; most of the rows on the order, {most} of {}, are met at {with_most:.2?}",
            rows.len()
        ),
        nearest <= BUILT_IN && with_most.iter().all(|share| *share >= BUILT_IN),
    )];
    let built_in = stiff.iter().find(|one| one.case.stiffness == BUILT_IN);
    if let Some((built_in, more)) = built_in.zip(lossy.iter().find(|one| one.case.eta > 1.0)) {
        let moved = built_in.order.iter().zip(more.order).take(3);
        let moved = moved.filter_map(|(a, b)| Some((a.as_ref()? - b?).abs())).fold(0.0, f64::max);
        claims.push(Claim::new(
            "recorded and published",
            "at the built-in stiffness a greater loss of the sliders does what softer felts do for the recorded strokes, and leaves the order of events",
            format!(
                "times {}: arrivals {:.1} instead of {:.1} ms off; hammer before key bottom moves by {moved:.2} ms",
                more.case.eta,
                1e3 * more.late_s(),
                1e3 * built_in.late_s()
            ),
            more.late_s() < 0.5 * built_in.late_s() && moved < 0.2,
        ));
    }
    claims
}
