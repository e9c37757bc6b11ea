//! What the struck hand does: its mass, the softness of its finger and the muscle behind it, and the travel time of the
//! key against loudness. Published travel times of two grands choose; all else that was published judges, and is not
//! looked at here.

use super::impact::tell;
use super::{Claim, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::level::{MASS_KG, Reference};
use erard::stroke::{HandStroke, Muscle, STRUCK_N_S_M, Touch};
use erard_workshop::validate::{Timing, published_ms};

/// Grands whose travel times choose, and the hammer speeds at which they do, m/s.
const CHOOSERS: [&str; 2] = ["Steinway C", "Yamaha Disklavier"];
const LEVELS_M_PER_S: [f64; 3] = [0.9, 2.0, 5.0];
/// Speeds at which hands arrive, m/s, in equal ratios.
const ARRIVALS_M_PER_S: [f64; 2] = [0.04, 3.0];
const TRIALS: usize = 130;
/// Levels between which the travel shall not jump: in ratios of 1.1 between these hammer speeds, m/s.
const RATIO: f64 = 1.1;
const FROM_TO_M_PER_S: [f64; 2] = [0.6, 5.0];

/// A hand: mass, kg, stiffness of the finger with its joints, N/m, and muscle for every m/s of arrival, N s/m.
#[derive(Clone, Copy)]
struct StruckHand {
    mass_kg: f64,
    finger_n_per_m: f64,
    muscle_n_s_m: f64,
}

/// Hammer speed, m/s, and time from the hand's contact to the impact, s, of hands from slow to fast; without those that
/// do not sound.
fn trials(instrument: &Instrument, hand: StruckHand) -> Result<Vec<[f64; 2]>, ReproduceError> {
    let wrong = |error: erard::level::LevelError| ReproduceError::Instrument(error.to_string());
    let mut other = instrument.clone();
    other.edit(|fields| {
        // The time constant of the finger stays.
        fields.finger.damping_n_s_per_m *= hand.finger_n_per_m / fields.finger.stiffness_n_per_m;
        fields.finger.stiffness_n_per_m = hand.finger_n_per_m;
    })?;
    let mut reference = Reference::new(&other, &mut |_| true).map_err(wrong)?;
    let [slow, fast] = ARRIVALS_M_PER_S;
    let mut found = Vec::new();
    for trial in 0..TRIALS {
        let arrives = slow * (fast / slow).powf(trial as f64 / (TRIALS - 1) as f64);
        let muscle = Muscle::Steady { force_n: hand.muscle_n_s_m * arrives };
        let stroke = HandStroke { muscle, ..HandStroke::struck(hand.mass_kg, arrives) };
        if let Some(impact) = reference.impact(&stroke, &mut |_| true).map_err(wrong)? {
            found.push([impact.hammer_speed_m_per_s, impact.time_s]);
        }
    }
    Ok(found)
}

/// Travel time at a hammer speed, s: that of the slowest hand that reaches it.
fn travel_s(trials: &[[f64; 2]], speed_m_per_s: f64) -> Option<f64> {
    let pair = trials.windows(2).find(|pair| pair[0][0] < speed_m_per_s && pair[1][0] >= speed_m_per_s)?;
    let [[slow, late], [fast, soon]] = [pair[0], pair[1]];
    Some(late + (soon - late) * (speed_m_per_s - slow) / (fast - slow))
}

/// Largest change of the travel between two levels that are a tenth apart, as a share, and the level above it, m/s.
fn largest_jump(trials: &[[f64; 2]]) -> [f64; 2] {
    let [from, to] = FROM_TO_M_PER_S;
    let levels = (0..).map(|n| from * RATIO.powi(n)).take_while(|speed| *speed <= to);
    let travels: Vec<[f64; 2]> = levels.filter_map(|speed| Some([speed, travel_s(trials, speed)?])).collect();
    travels.windows(2).fold([0.0, f64::NAN], |most, pair| {
        let share = (pair[1][1] / pair[0][1] - 1.0).abs();
        if share > most[0] { [share, pair[1][0]] } else { most }
    })
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let header =
        ["hand (g)", "finger (N/mm)", "muscle (N s/m)", "0.9 m/s", "2 m/s", "5 m/s", "largest jump", "at (m/s)"];
    let mut table = Table::new(
        "From the hand's contact to the impact (ms), and the largest change of that time between levels a tenth apart; \
         struck touch, the instrument's finger and hand first",
        &header,
    );
    let range = |speed: f64| {
        let of = CHOOSERS.map(|grand| published_ms(grand, Touch::Struck, Timing::Travel, speed).unwrap_or(f64::NAN));
        [of[0].min(of[1]), of[0].max(of[1])]
    };
    let published = LEVELS_M_PER_S.map(|speed| {
        let [low, high] = range(speed);
        format!("{low:.0}-{high:.0}")
    });
    table.row(
        ["two grands".into(), "-".into(), "-".into()].into_iter().chain(published).chain(["-".into(), "-".into()]),
    );
    let own = StruckHand {
        mass_kg: MASS_KG,
        finger_n_per_m: instrument.finger.stiffness_n_per_m,
        muscle_n_s_m: STRUCK_N_S_M,
    };
    let mut hands = vec![own];
    for mass_kg in [0.1, MASS_KG] {
        for finger_n_per_m in [own.finger_n_per_m, 8e3, 4e3, 3e3, 2e3] {
            hands.extend([STRUCK_N_S_M, 9.0, 14.0].map(|muscle_n_s_m| StruckHand {
                mass_kg,
                finger_n_per_m,
                muscle_n_s_m,
            }));
        }
    }
    let mut jumps = Vec::new();
    for (n, hand) in hands.iter().enumerate() {
        tell(progress, n as f64 / hands.len() as f64)?;
        let trials = trials(instrument, *hand)?;
        let travels = LEVELS_M_PER_S.map(|speed| travel_s(&trials, speed));
        let [jump, at] = largest_jump(&trials);
        let ms = travels.map(|s| s.map_or_else(|| "-".to_owned(), |s| format!("{:.0}", 1e3 * s)));
        let own = [
            format!("{:.0}", 1e3 * hand.mass_kg),
            format!("{}", 1e-3 * hand.finger_n_per_m),
            format!("{}", hand.muscle_n_s_m),
        ];
        table.row(own.into_iter().chain(ms).chain([format!("{:.0} %", 100.0 * jump), format!("{at:.2}")]));
        jumps.push(jump);
    }
    let smoothest = jumps.iter().copied().fold(f64::INFINITY, f64::min);
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    Ok(Section {
        text: vec![
            "A hand that arrives gives most of its momentum in the first milliseconds. If it is heavy and its finger hard, \
             the hammer leaves the jack at once and flies on alone; the key follows later. If its finger and joints are \
             soft, or muscle rather than momentum drives it, the hammer is pushed all the way."
                .to_owned(),
        ],
        claims: vec![
            Claim::new(
                "this program",
                "the built-in struck hand jumps: its travel changes by more than 15 % between levels a tenth apart",
                percent(jumps[0]),
                jumps[0] > 0.15,
            ),
            Claim::new(
                "this program",
                "a softer finger and more muscle make the travel smooth to 15 %",
                format!("{} at the least", percent(smoothest)),
                smoothest <= 0.15,
            ),
        ],
        tables: vec![table],
        ..Section::default()
    })
}
