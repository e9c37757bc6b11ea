//! What the struck hand does: its mass, the joints of its finger and the muscle behind it. Published travel times of
//! two grands choose joints and muscle; all else that was published judges (`erard validate`). And what the muscle of a
//! pressed hand does after let-off, which nothing was chosen by.

use moreau::Settings;

use super::impact::tell;
use super::lying::Keys;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table, bending};
use erard::instrument::Instrument;
use erard::level::{HOLD_N, HandKind, LEVELS, LevelError, MASS_KG, Reference};
use erard::player::{Hand, Input, Joints};
use erard::run::{Run, Setup, press_by_hand, simulate};
use erard::stroke::{HandStroke, Muscle, STRUCK_JOINTS, STRUCK_N_S_M, Touch};
use erard_workshop::validate::{Timing, fastest_s, grands, published_ms};

/// Grands whose travel times choose, and the hammer speeds at which they do, m/s.
const CHOOSERS: [&str; 2] = ["Steinway C", "Yamaha Disklavier"];
const CHOOSING_M_PER_S: [f64; 3] = [0.9, 2.0, 5.0];
/// Speeds at which hands arrive, m/s, in equal ratios.
const ARRIVALS_M_PER_S: [f64; 2] = [0.04, 3.0];
const TRIALS: usize = 130;
/// Neighbouring levels are in this ratio. From one to the next the travel shall change by no more than this share.
const RATIO: f64 = 1.1;
const JUMP: f64 = 0.15;
/// Levels by the speed of the hammer and by that of the hand, m/s.
const HAMMERS_M_PER_S: [f64; 2] = [0.6, 5.0];
const HANDS_M_PER_S: [f64; 2] = [0.2, 3.0];
/// Hands of the table, m/s: the softest, the loudest, and how many.
const SHOWN_M_PER_S: [f64; 2] = [0.12, 3.0];
const SHOWN: usize = 18;
/// Joints and muscles among which travel times choose: compliance, m/N, retardation time, s, muscle, N s/m.
const COMPLIANCES_M_PER_N: [f64; 3] = [0.1e-3, 0.2e-3, 0.4e-3];
const RETARDATIONS_S: [f64; 3] = [4e-3, 8e-3, 16e-3];
const MUSCLES_N_S_M: [f64; 3] = [6.0, 8.0, 10.0];
/// Times within which a muscle grows that is not there at first, s.
const GROWS: [(&str, f64); 2] = [("grows in 10 ms", 0.01), ("grows in 20 ms", 0.02)];
/// Step, s, and time after the impact that is looked at, s.
const STEP_S: f64 = 50e-6;
const AFTER_S: f64 = 0.04;

fn wrong(error: LevelError) -> ReproduceError {
    match error {
        LevelError::Interrupted => erard::run::SimulationError::Interrupted.into(),
        error => ReproduceError::Instrument(error.to_string()),
    }
}

/// A struck hand. Its muscle presses with `muscle_n_s_m` for every m/s of arrival, at once or within a time, s.
#[derive(Clone, Copy)]
struct StruckHand {
    mass_kg: f64,
    joints: Joints,
    muscle_n_s_m: f64,
    within_s: f64,
}

/// The built-in one.
const OWN: StruckHand =
    StruckHand { mass_kg: MASS_KG, joints: STRUCK_JOINTS, muscle_n_s_m: STRUCK_N_S_M, within_s: 0.0 };

impl StruckHand {
    fn stroke(self, arrives_m_per_s: f64) -> HandStroke {
        let built_in = HandStroke::struck(self.mass_kg, arrives_m_per_s);
        let force_n = self.muscle_n_s_m * arrives_m_per_s;
        let muscle = match self.within_s {
            0.0 => Muscle::Steady { force_n },
            within_s => Muscle::Swells { force_n, within_s },
        };
        HandStroke { hand: Hand { joints: self.joints, ..built_in.hand }, muscle, ..built_in }
    }

    fn with_joints(self, compliance_m_per_n: f64, retardation_s: f64) -> Self {
        StruckHand { joints: Joints { compliance_m_per_n, retardation_s }, ..self }
    }

    /// Compliance, mm/N, retardation time, ms, muscle, N s/m.
    fn cells(self) -> [String; 3] {
        let Joints { compliance_m_per_n, retardation_s } = self.joints;
        let muscle = format!("{}", self.muscle_n_s_m);
        if compliance_m_per_n == 0.0 {
            return ["stiff".into(), "-".into(), muscle];
        }
        [format!("{}", round(1e3 * compliance_m_per_n)), format!("{}", round(1e3 * retardation_s)), muscle]
    }
}

/// To three decimals.
fn round(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

/// Speeds in equal ratios, m/s.
fn speeds([from, to]: [f64; 2], count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |n| from * (to / from).powf(n as f64 / (count - 1) as f64))
}

/// A hand's trials, slow to fast; without those that do not sound.
struct Trials {
    /// Speed of arrival, m/s, hammer speed, m/s, and time from the hand's contact to the impact, s.
    rows: Vec<[f64; 3]>,
}

impl Trials {
    fn of(reference: &mut Reference, hand: StruckHand) -> Result<Self, ReproduceError> {
        let mut rows = Vec::new();
        for arrives in speeds(ARRIVALS_M_PER_S, TRIALS) {
            let impact = reference.impact(&hand.stroke(arrives), &mut |_| true).map_err(wrong)?;
            rows.extend(impact.map(|impact| [arrives, impact.hammer_speed_m_per_s, impact.time_s]));
        }
        Ok(Trials { rows })
    }

    /// Travel time at a speed of the hand (`by` 0) or of the hammer (1), m/s: that of the slowest hand that reaches it.
    fn travel_s(&self, by: usize, speed_m_per_s: f64) -> Option<f64> {
        let pair = self.rows.windows(2).find(|pair| pair[0][by] < speed_m_per_s && pair[1][by] >= speed_m_per_s)?;
        let share = (speed_m_per_s - pair[0][by]) / (pair[1][by] - pair[0][by]);
        Some(pair[0][2] + share * (pair[1][2] - pair[0][2]))
    }

    /// Travel times at the choosing levels, s; `None` where the hand does not reach one.
    fn chosen_by(&self) -> Option<[f64; 3]> {
        let [a, b, c] = CHOOSING_M_PER_S.map(|speed| self.travel_s(1, speed));
        Some([a?, b?, c?])
    }

    /// Root mean square of the logarithms of these travel times over the mean of the two grands.
    fn misfit(&self) -> Option<f64> {
        let travels = self.chosen_by()?;
        let square = |(s, speed): (f64, f64)| {
            let [low, high] = published(&CHOOSERS, Timing::Travel, speed);
            (1e3 * s / (low * high).sqrt()).ln().powi(2)
        };
        Some((travels.into_iter().zip(CHOOSING_M_PER_S).map(square).sum::<f64>() / 3.0).sqrt())
    }

    /// Largest change of the travel between two levels a tenth apart, as a share, and the upper level, m/s: by the
    /// speed of the hand (`by` 0) or of the hammer (1).
    fn largest_jump(&self, by: usize) -> [f64; 2] {
        let [from, to] = [HANDS_M_PER_S, HAMMERS_M_PER_S][by];
        let levels = (0..).map(|n| from * RATIO.powi(n)).take_while(|speed| *speed <= to);
        let travels: Vec<[f64; 2]> = levels.filter_map(|speed| Some([speed, self.travel_s(by, speed)?])).collect();
        travels.windows(2).fold([0.0, f64::NAN], |most, pair| {
            let share = (pair[1][1] / pair[0][1] - 1.0).abs();
            if share > most[0] { [share, pair[1][0]] } else { most }
        })
    }

    /// The larger one of both jumps.
    fn jump(&self) -> f64 {
        self.largest_jump(0)[0].max(self.largest_jump(1)[0])
    }

    /// Travel times at the choosing levels, ms, and both jumps.
    fn cells(&self) -> Vec<String> {
        let ms = CHOOSING_M_PER_S.map(|speed| shown(self.travel_s(1, speed).map(|s| 1e3 * s), 1));
        let jumps = [1, 0].map(|by| {
            let [share, at] = self.largest_jump(by);
            format!("{:.0} % at {at:.2}", 100.0 * share)
        });
        ms.into_iter().chain(jumps).collect()
    }
}

fn shown(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

/// The smallest and the largest published value of some grands, ms.
fn published(of: &[&str], quantity: Timing, speed_m_per_s: f64) -> [f64; 2] {
    let values = of.iter().filter_map(|grand| published_ms(grand, Touch::Struck, quantity, speed_m_per_s));
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], ms| [low.min(ms), high.max(ms)])
}

/// A struck note. Times in ms, forces in N.
struct Struck {
    arrives_m_per_s: f64,
    hammer_m_per_s: f64,
    travel_ms: f64,
    flight_ms: f64,
    off_knuckle_ms: Option<f64>,
    bottom_ms: Option<f64>,
    /// Largest force of the finger up to the impact, and of all.
    peaks_n: [f64; 2],
    is_checked: bool,
    impacts: usize,
}

impl Struck {
    /// `None` where it does not sound.
    fn of(
        instrument: &Instrument,
        reference: &mut Reference,
        hand: StruckHand,
        arrives: f64,
    ) -> Result<Option<Self>, ReproduceError> {
        let stroke = hand.stroke(arrives);
        let Some(impact) = reference.impact(&stroke, &mut |_| true).map_err(wrong)? else { return Ok(None) };
        let run = held(instrument, stroke.holding(impact.time_s, HOLD_N), impact.time_s + AFTER_S)?;
        let events = &run.events;
        let ms = |s: Option<f64>| s.map(|s| 1e3 * s);
        Ok(Some(Struck {
            arrives_m_per_s: arrives,
            hammer_m_per_s: impact.hammer_speed_m_per_s,
            travel_ms: 1e3 * impact.time_s,
            flight_ms: 1e3 * (impact.time_s - fastest_s(&run, impact.time_s)),
            off_knuckle_ms: ms(events.free_flight_s()),
            bottom_ms: ms(events.key_bottom_after_impact_s()),
            peaks_n: [most(&run, 0.0, impact.time_s), most(&run, 0.0, f64::INFINITY)],
            is_checked: events.check_s.is_some(),
            impacts: events.impacts.len(),
        }))
    }

    fn cells(&self) -> Vec<String> {
        vec![
            format!("{:.2}", self.arrives_m_per_s),
            format!("{:.2}", self.hammer_m_per_s),
            format!("{:.1}", self.travel_ms),
            format!("{:.1}", self.flight_ms),
            shown(self.off_knuckle_ms, 1),
            shown(self.bottom_ms, 1),
            format!("{:.1}", self.peaks_n[0]),
            format!("{:.1}", self.peaks_n[1]),
            if self.is_checked { "yes" } else { "no" }.into(),
            format!("{}", self.impacts),
        ]
    }
}

fn held(instrument: &Instrument, stroke: HandStroke, seconds: f64) -> Result<Run, ReproduceError> {
    Ok(press_by_hand(instrument, &stroke, &recorded(seconds), &mut |_| true)?)
}

fn recorded(seconds: f64) -> Setup {
    Setup { settings: Settings::new(STEP_S), record_every: Some(1), ledger: false, ..Setup::new(seconds) }
}

/// Largest force of the finger between two instants, N.
fn most(run: &Run, from_s: f64, to_s: f64) -> f64 {
    let rows = run.time_s.partition_point(|&t| t < from_s)..run.time_s.partition_point(|&t| t <= to_s);
    run.force_n[rows].iter().copied().fold(0.0, f64::max)
}

/// The hand with each of its numbers halved and doubled, with other muscles, and with stiff joints.
fn variants() -> Vec<(&'static str, StruckHand)> {
    let Joints { compliance_m_per_n: compliance, retardation_s: time } = OWN.joints;
    let muscle = |muscle_n_s_m: f64| StruckHand { muscle_n_s_m, ..OWN };
    let mut all = vec![
        ("built in", OWN),
        ("mass / 2", StruckHand { mass_kg: 0.5 * OWN.mass_kg, ..OWN }),
        ("mass x 2", StruckHand { mass_kg: 2.0 * OWN.mass_kg, ..OWN }),
        ("compliance / 2", OWN.with_joints(0.5 * compliance, time)),
        ("compliance x 2", OWN.with_joints(2.0 * compliance, time)),
        ("time / 2", OWN.with_joints(compliance, 0.5 * time)),
        ("time x 2", OWN.with_joints(compliance, 2.0 * time)),
        ("muscle / 2", muscle(0.5 * OWN.muscle_n_s_m)),
        ("muscle x 2", muscle(2.0 * OWN.muscle_n_s_m)),
        ("no muscle", muscle(0.0)),
    ];
    all.extend(GROWS.map(|(what, within_s)| (what, StruckHand { within_s, ..OWN })));
    all.push(("stiff joints", OWN.with_joints(0.0, 0.0)));
    all
}

/// What the muscle of a pressed hand does.
#[derive(Clone, Copy)]
enum After {
    /// It relaxes from the impact on, as in the built-in touch.
    Relaxes,
    /// It presses on.
    Presses,
    /// It stops at once at an instant: at let-off, at key bottom.
    StopsAt(fn(&Run) -> Option<f64>),
}

/// The pressed hand at a level: how its muscle acts after let-off, and the force of its finger.
fn pressed(table: &mut Table, instrument: &Instrument, key: &str) -> Result<Vec<[f64; 2]>, ReproduceError> {
    let mut reference = Reference::new(instrument, &mut |_| true).map_err(wrong)?;
    let ways: [(&str, Joints, After); 6] = [
        ("relaxes from the impact (built in)", Joints::STIFF, After::Relaxes),
        ("presses on", Joints::STIFF, After::Presses),
        ("stops at let-off", Joints::STIFF, After::StopsAt(|run| run.events.let_off_s)),
        ("stops at key bottom", Joints::STIFF, After::StopsAt(|run| run.events.key_bottom_s)),
        ("relaxes; the struck hand's joints", STRUCK_JOINTS, After::Relaxes),
        ("stops at let-off; these joints", STRUCK_JOINTS, After::StopsAt(|run| run.events.let_off_s)),
    ];
    let mut peaks = Vec::new();
    for (name, speed_m_per_s) in [LEVELS[2], LEVELS[4]] {
        for (way, joints, after) in ways {
            let kind = HandKind { joints, ..HandKind::new(Touch::Pressed, MASS_KG) };
            let solved = reference.solve(kind, speed_m_per_s, &mut |_| true).map_err(wrong)?;
            let seconds = solved.impact.time_s + AFTER_S;
            let run = match after {
                After::Relaxes => held(instrument, solved.held(), seconds)?,
                After::Presses => held(instrument, solved.stroke, seconds)?,
                After::StopsAt(instant) => {
                    let stops_s = instant(&held(instrument, solved.stroke, seconds)?).unwrap_or(f64::INFINITY);
                    let drive = |t: f64| if t < stops_s { solved.stroke.input(t) } else { Input::Force(0.0) };
                    let setup = Setup { hand: Some(solved.stroke.hand), ..recorded(seconds) };
                    simulate(instrument, &drive, &setup, &mut |_| true)?
                }
            };
            let bottom_s = run.events.key_bottom_s.unwrap_or(f64::INFINITY);
            let [before, later] = [most(&run, 0.0, bottom_s), most(&run, bottom_s, f64::INFINITY)];
            table.row([
                key.to_owned(),
                name.to_owned(),
                way.to_owned(),
                shown(run.events.hammer_speed_m_per_s(), 2),
                format!("{before:.0}"),
                format!("{later:.0}"),
            ]);
            peaks.push([before, later]);
        }
    }
    Ok(peaks)
}

/// A value of a struck note, ms; `None` where it does not happen.
type Value = fn(&Struck) -> Option<f64>;

/// Travel, key bottom and free flight over the hammer's speed: three grands, and the model.
fn chart(played: &[(&str, Vec<Struck>)]) -> Chart {
    let value: [(Timing, Value, &str); 3] = [
        (Timing::Travel, |one| Some(one.travel_ms), "hand's contact to string (ms)"),
        (Timing::KeyBottom, |one| one.bottom_ms, "string to key bottom (ms)"),
        (Timing::FreeFlight, |one| Some(one.flight_ms), "largest speed to string (ms)"),
    ];
    let levels: Vec<f64> = speeds(HAMMERS_M_PER_S, 25).collect();
    let panels = value.map(|(quantity, of, y_label)| {
        let grands = grands().into_iter().enumerate().map(|(n, grand)| ChartCurve {
            label: grand.to_owned(),
            x: levels.clone(),
            y: levels.iter().filter_map(|&speed| published_ms(grand, Touch::Struck, quantity, speed)).collect(),
            colour: n,
            mark: Dash::Dashed,
        });
        let models = played.iter().enumerate().map(|(n, (name, notes))| {
            let [from, to] = HAMMERS_M_PER_S;
            let within = notes.iter().filter(|one| (from..=to).contains(&one.hammer_m_per_s));
            let (x, y) = within.filter_map(|one| Some((one.hammer_m_per_s, of(one)?))).unzip();
            ChartCurve { label: (*name).to_owned(), x, y, colour: 3 + n, mark: Dash::Points }
        });
        ChartPanel {
            y_label: y_label.into(),
            y_log: quantity == Timing::Travel,
            y_range: None,
            curves: grands.chain(models).collect(),
        }
    });
    Chart {
        title: "Struck notes beside three grands".into(),
        caption: "travel of the Steinway and the Yamaha at 0.9, 2 and 5 m/s chose joints and muscle; the rest judges"
            .into(),
        x_label: "hammer speed at the string (m/s)".into(),
        x_log: true,
        panels: panels.into(),
    }
}

pub(super) fn section(asked: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let Keys { nailed, lying } = Keys::of(&bending(asked)?)?;
    let keys = [("nailed", &nailed), ("lying", &lying)];
    let mut references = Vec::new();
    for (_, instrument) in keys {
        references.push(Reference::new(instrument, &mut |_| true).map_err(wrong)?);
    }
    let header = ["travel at 0.9", "at 2", "at 5 m/s", "jump by hammer", "by hand"];
    let of_hands = ["joints (mm/N)", "time (ms)", "muscle (N s/m)"];

    let mut choice = Table::new(
        "Which joints and which muscle travel times choose (ms), key nailed; the largest change of the travel between \
         levels a tenth apart, and the level (m/s)",
        &[&of_hands[..], &header[..], &["misfit"]].concat(),
    );
    let published = CHOOSING_M_PER_S.map(|speed| {
        let [low, high] = published(&CHOOSERS, Timing::Travel, speed);
        format!("{low:.1}-{high:.1}")
    });
    let dashes = |count: usize| core::iter::repeat_n("-".to_owned(), count);
    choice.row(["two grands".to_owned()].into_iter().chain(dashes(2)).chain(published).chain(dashes(3)));
    let mut hands: Vec<StruckHand> =
        MUSCLES_N_S_M.map(|muscle_n_s_m| StruckHand { muscle_n_s_m, ..OWN.with_joints(0.0, 0.0) }).into();
    for compliance in COMPLIANCES_M_PER_N {
        for time in RETARDATIONS_S {
            let with = |muscle_n_s_m| StruckHand { muscle_n_s_m, ..OWN.with_joints(compliance, time) };
            hands.extend(MUSCLES_N_S_M.map(with));
        }
    }
    let mut misfits = Vec::new();
    for (n, hand) in hands.iter().enumerate() {
        tell(progress, 0.5 * n as f64 / hands.len() as f64)?;
        let trials = Trials::of(&mut references[0], *hand)?;
        let misfit = trials.misfit();
        let cells = hand.cells().into_iter().chain(trials.cells());
        choice.row(cells.chain([shown(misfit.map(|share| 100.0 * share), 1) + " %"]));
        misfits.push((misfit.unwrap_or(f64::INFINITY), trials.jump(), hand.joints, hand.muscle_n_s_m));
    }
    let smooth = misfits.iter().filter(|(_, jump, ..)| *jump <= JUMP);
    let best = smooth.min_by(|a, b| a.0.total_cmp(&b.0)).copied();
    let is_own = |(.., joints, muscle): &&(f64, f64, _, f64)| *joints == OWN.joints && *muscle == OWN.muscle_n_s_m;
    let own_misfit = misfits.iter().find(is_own).map_or(f64::INFINITY, |one| one.0);

    let mut varied = Table::new(
        "The built-in struck hand and its variants: travel (ms) and jumps as above",
        &[&["key", "what"], &header[..]].concat(),
    );
    let mut own = Vec::new();
    let (mut roughest, mut stiff): (f64, f64) = (0.0, f64::INFINITY);
    for (key, (name, _)) in keys.iter().enumerate() {
        for (n, (what, hand)) in variants().into_iter().enumerate() {
            tell(progress, 0.5 + 0.1 * (key as f64 + n as f64 / 13.0))?;
            let trials = Trials::of(&mut references[key], hand)?;
            varied.row([(*name).to_owned(), what.to_owned()].into_iter().chain(trials.cells()));
            match what {
                "stiff joints" => stiff = stiff.min(trials.jump()),
                "no muscle" => {}
                _ => roughest = roughest.max(trials.jump()),
            }
            if what == "built in" {
                own.push(trials);
            }
        }
    }

    let mut table = Table::new(
        "The built-in struck hand: from its contact to the string (ms), free flight from the hammer's largest speed and \
         from the last push at the knuckle (ms), key bottom after the string (ms), largest force of the finger up to \
         the impact and of all (N)",
        &[
            "key",
            "hand (m/s)",
            "hammer (m/s)",
            "travel",
            "free flight",
            "off knuckle",
            "bottom",
            "up to impact",
            "largest",
            "checked",
            "impacts",
        ],
    );
    let mut played = Vec::new();
    let before = StruckHand { muscle_n_s_m: MUSCLES_N_S_M[0], ..OWN.with_joints(0.0, 0.0) };
    for (key, label, hand) in
        [(0, "model, stiff joints", before), (0, "model, key nailed", OWN), (1, "model, key lying", OWN)]
    {
        tell(progress, 0.7 + 0.08 * played.len() as f64)?;
        let (name, instrument) = keys[key];
        let mut notes = Vec::new();
        for arrives in speeds(SHOWN_M_PER_S, SHOWN) {
            notes.extend(Struck::of(instrument, &mut references[key], hand, arrives)?);
        }
        if label != "model, stiff joints" {
            notes.iter().for_each(|one| table.row([name.to_owned()].into_iter().chain(one.cells())));
        }
        played.push((label, notes));
    }

    let mut after = Table::new(
        "A pressed hand of 200 g: what its muscle does after let-off, and the largest force of the finger before and \
         after key bottom (N)",
        &["key", "level", "the muscle", "hammer (m/s)", "before", "after"],
    );
    let mut peaks = Vec::new();
    for (n, (name, instrument)) in keys.into_iter().enumerate() {
        tell(progress, 0.94 + 0.03 * n as f64)?;
        peaks.push(pressed(&mut after, instrument, name)?);
    }

    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let program = |says: &str, measured: String, holds: bool| Claim::new("this program", says, measured, holds);
    let travels: Vec<[f64; 3]> = own.iter().filter_map(Trials::chosen_by).collect();
    let is_within = |(ms, speed): (f64, f64)| {
        let [low, high] = self::published(&CHOOSERS, Timing::Travel, speed);
        (low..=high).contains(&ms)
    };
    let all_within = travels.len() == keys.len()
        && travels.iter().all(|of| of.iter().map(|s| 1e3 * s).zip(CHOOSING_M_PER_S).all(is_within));
    let jump = own.iter().map(Trials::jump).fold(0.0, f64::max);
    let ordered = played[1..].iter().all(|(_, notes)| {
        let bottoms = notes.iter().filter_map(|one| one.bottom_ms);
        let [soft, loud] = [notes.first(), notes.last()].map(|one| one.and_then(|one| one.bottom_ms));
        soft.is_some_and(|ms| ms > 0.0)
            && loud.is_some_and(|ms| ms < 0.0)
            && notes.iter().all(|one| one.impacts == 1 && one.flight_ms > 0.0)
            && bottoms.count() == notes.len()
    });
    // ff: the last six of the ways; the third stops at let-off, the fourth at key bottom.
    let of_ff = |way: usize| peaks.iter().map(|of| of[6 + way][1]).fold(0.0, f64::max);
    // It was chosen before heel and lever rubbed.
    let chosen = best.is_some_and(|(misfit, ..)| own_misfit < misfit + 0.01);
    Ok(Section {
        text: vec![
            "A hand that arrives gives most of its momentum in the first milliseconds. If its finger is stiff, the hammer \
             leaves the jack at once and flies on alone; the key follows later. The joints of a finger yield, and are slow \
             to: then the hand pushes the hammer all the way. The joints are in series with the flesh of the fingertip, \
             which is the instrument's: compliances add, and so do the losses (damping over the square of stiffness). \
             Their retardation time is damping over stiffness."
                .to_owned(),
            format!(
                "Travel of two grands at 0.9, 2 and 5 m/s chooses compliance, time and muscle of a hand of 200 g among \
                 those of the first table, under the condition that the travel does not jump: by no more than {} \
                 between levels a tenth apart, by the hammer's speed from {} to {} m/s and by the hand's from {} to {} \
                 m/s. All else that was published judges (`erard validate`).",
                percent(JUMP),
                HAMMERS_M_PER_S[0],
                HAMMERS_M_PER_S[1],
                HANDS_M_PER_S[0],
                HANDS_M_PER_S[1]
            ),
        ],
        claims: vec![
            program(
                "a struck hand with stiff joints jumps: its travel changes by more than 15 % between levels a tenth apart",
                format!("by {}", percent(stiff)),
                stiff > JUMP,
            ),
            program("the travel of the built-in struck hand does not", format!("by {}", percent(jump)), jump <= JUMP),
            program(
                "nor does it with mass, compliance, time or muscle halved or doubled, or with a muscle that grows",
                format!("by {}", percent(roughest)),
                roughest <= JUMP,
            ),
            program(
                "the misfit of the built-in struck hand is within a hundredth of the smallest among smooth ones",
                best.map_or_else(
                    || "none is smooth".to_owned(),
                    |(misfit, ..)| format!("{:.1} and {:.1} %", 100.0 * own_misfit, 100.0 * misfit),
                ),
                chosen,
            ),
            program(
                "its travel at 0.9, 2 and 5 m/s lies between the two grands that chose it, on both keys",
                travels.iter().map(|of| of.map(|s| format!("{:.1}", 1e3 * s)).join(", ")).collect::<Vec<_>>().join("; "),
                all_within,
            ),
            program(
                "a soft struck key is down after the impact, a loud one before it, and each sounds once",
                format!("{} notes", played[1..].iter().map(|(_, notes)| notes.len()).sum::<usize>()),
                ordered,
            ),
            program(
                "a muscle that stops at key bottom leaves most of the force with which a pressed hand lands at ff: it is \
                 the hand's momentum",
                format!("{:.0} of {:.0} N", of_ff(3), of_ff(0)),
                of_ff(3) > 0.5 * of_ff(0),
            ),
        ],
        charts: vec![chart(&played)],
        tables: vec![table, choice, varied, after],
        ..Section::default()
    })
}
