//! Times of a note's events: their convergence with the step, and their sensitivity to a hundredth of the hand's force.
//!
//! After the impact felts open and close in an order that small differences may decide. If they do, only a distribution
//! is a result there, not a number.

use moreau::Settings;

use super::impact::{NEIGHBOURS, halvings, neighbouring, tell};
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::level::{HandKind, LEVELS, LevelError, MASS_KG, Reference};
use erard::run::{Events, Run, Setup, SimulationError, press_by_hand};
use erard::stroke::{HandStroke, Muscle, Touch};

/// The usual step, s, and number of steps, each half of the one before; divisor of the smallest for the reference.
const STEPS: (f64, i32) = (50e-6, 5);
const REFERENCE: f64 = 8.0;
/// Duration after the impact, s: a checked hammer then hangs still.
const AFTER_S: f64 = 0.2;
/// Indices of the levels played: pp, mf and ff.
const PLAYED: [usize; 3] = [0, 2, 4];
/// Total relative variation of the hand's force, and number of notes.
const INPUT: f64 = 0.01;
const DRAWS: usize = 201;
/// Largest jump of a smooth result between neighbouring notes, as a share of its spread; a linear one jumps by a
/// two-hundredth.
const SMOOTH: f64 = 0.25;
/// Steps per recorded row of these notes.
const KEPT: u64 = 20;
/// An event does not converge if its error shrinks more slowly than the step to this power.
const LEAST_ORDER: f64 = 0.87;

/// Time of an event, s; `None` if it does not happen.
type Instant = fn(&Events) -> Option<f64>;

/// Events, in the words of the book.
const EVENTS: [(&str, Instant); 5] = [
    ("key start", |e| e.key_start_s),
    ("last push", |e| e.let_off_s),
    ("impact", Events::hammer_contact_s),
    ("key bottom", |e| e.key_bottom_s),
    ("check", |e| e.check_s),
];
/// Times of all events, s.
type Instants = [f64; EVENTS.len()];

/// A level's hand, and the end of its run, s.
struct Played {
    name: &'static str,
    stroke: HandStroke,
    until_s: f64,
}

impl Played {
    fn run(
        &self,
        instrument: &Instrument,
        stroke: &HandStroke,
        step_s: f64,
        record_every: u64,
    ) -> Result<Run, SimulationError> {
        let setup = Setup {
            settings: Settings::new(step_s),
            record_every: Some(record_every),
            ledger: false,
            ..Setup::new(self.until_s)
        };
        press_by_hand(instrument, stroke, &setup, &mut |_| true)
    }

    fn instants(&self, instrument: &Instrument, step_s: f64) -> Result<Instants, SimulationError> {
        let events = self.run(instrument, &self.stroke, step_s, u64::MAX)?.events;
        Ok(EVENTS.map(|(_, of)| of(&events).unwrap_or(f64::NAN)))
    }

    /// The same hand with another force.
    fn with(&self, factor: f64) -> HandStroke {
        match self.stroke.muscle {
            Muscle::Swells { force_n, within_s } => {
                HandStroke { muscle: Muscle::Swells { force_n: factor * force_n, within_s }, ..self.stroke }
            }
            _ => self.stroke,
        }
    }
}

fn levels(instrument: &Instrument) -> Result<Vec<Played>, ReproduceError> {
    let failed = |error: LevelError| ReproduceError::Instrument(error.to_string());
    let mut reference = Reference::new(instrument, &mut |_| true).map_err(failed)?;
    let kind = HandKind::new(Touch::Pressed, MASS_KG);
    PLAYED
        .into_iter()
        .map(|level| {
            let (name, speed_m_per_s) = LEVELS[level];
            let solved = reference.solve(kind, speed_m_per_s, &mut |_| true).map_err(failed)?;
            Ok(Played { name, stroke: solved.held(), until_s: solved.impact.time_s + AFTER_S })
        })
        .collect()
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let levels = levels(instrument)?;
    let mut section = Section {
        text: vec![format!(
            "Hands of 200 g press pp, mf and ff. Errors are root mean squares over {NEIGHBOURS} steps from h to h - 7/64 h, against a run with a {REFERENCE:.0} times smaller \
             step than the smallest. For the scatter the force of the hand's muscle is varied by {:.0} % as a whole, in {DRAWS} even steps.",
            100.0 * INPUT
        )],
        ..Section::default()
    };
    converge(instrument, &levels, &mut section, &mut |share| progress(0.7 * share))?;
    scatter(instrument, &levels, &mut section, &mut |share| progress(0.7 + 0.3 * share))?;
    Ok(section)
}

/// Errors of the events at each step.
fn converge(
    instrument: &Instrument,
    levels: &[Played],
    section: &mut Section,
    progress: &mut Progress,
) -> Result<(), ReproduceError> {
    let steps = halvings(STEPS.0, STEPS.1);
    let names = EVENTS.map(|(name, _)| format!("{name}, us"));
    let header: Vec<&str> = ["level", "step, us"].into_iter().chain(names.iter().map(String::as_str)).collect();
    let mut table = Table::new("Errors of the events at each step", &header);
    let mut orders = [f64::INFINITY; EVENTS.len()];
    let mut largest = Instants::default();
    for (n, played) in levels.iter().enumerate() {
        let of_all = |share: f64| (n as f64 + share) / levels.len() as f64;
        tell(progress, of_all(0.0))?;
        let exact = played.instants(instrument, steps[steps.len() - 1] / REFERENCE)?;
        let errors = neighbouring(
            &steps,
            &mut |_, step_s| {
                let found = played.instants(instrument, step_s)?;
                Ok(std::array::from_fn::<_, { EVENTS.len() }, _>(|event| found[event] - exact[event]))
            },
            &mut |share| progress(of_all(0.3 + 0.7 * share)),
        )?;
        for (step, errors) in steps.iter().zip(&errors) {
            let cells = errors.map(|error| shown(error * 1e6, 3));
            table.row([played.name.to_owned(), format!("{:.3}", step * 1e6)].into_iter().chain(cells));
        }
        let fitted: [f64; EVENTS.len()] =
            std::array::from_fn(|event| order(&steps, &errors.iter().map(|of| of[event]).collect::<Vec<_>>()));
        let cells = fitted.map(|order| shown(order, 2));
        table.row([played.name.to_owned(), "order".to_owned()].into_iter().chain(cells));
        for event in 0..EVENTS.len() {
            orders[event] = orders[event].min(fitted[event]);
            largest[event] = largest[event].max(errors[0][event]);
        }
    }
    section.tables.push(table);
    for (event, (name, _)) in EVENTS.iter().enumerate() {
        section.claims.push(Claim::new(
            "this program",
            format!("{name}: halving the step halves its error at least"),
            format!(
                "order {:.2} or more; error at {:.0} us {:.1} us or less",
                orders[event],
                STEPS.0 * 1e6,
                largest[event] * 1e6
            ),
            orders[event] > LEAST_ORDER,
        ));
    }
    Ok(())
}

/// Formats a number; a dash if it is not finite.
fn shown(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "-".into() }
}

/// Slope of a straight line through the logarithms, by least squares.
fn order(steps: &[f64], errors: &[f64]) -> f64 {
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / steps.len() as f64;
    let [x, y] = [steps, errors].map(|values| values.iter().map(|v| v.ln()).collect::<Vec<_>>());
    let (mx, my) = (mean(&mut x.iter().copied()), mean(&mut y.iter().copied()));
    let both: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
    both / x.iter().map(|x| (x - mx) * (x - mx)).sum::<f64>()
}

/// A result of a note of slightly different force.
type Outcome = fn(&Run) -> Option<f64>;

/// Number of results that belong to the note up to impact and key bottom.
const UP_TO_IMPACT: usize = 4;
const RESULTS: [(&str, &str, Outcome); 7] = [
    ("hammer speed", "m/s", |run| run.events.hammer_speed_m_per_s()),
    ("key start to last push", "ms", |run| after_start_ms(run, run.events.let_off_s)),
    ("key start to impact", "ms", |run| after_start_ms(run, run.events.hammer_contact_s())),
    ("key start to key bottom", "ms", |run| after_start_ms(run, run.events.key_bottom_s)),
    ("impact to check", "ms", |run| Some(1e3 * (run.events.check_s? - run.events.hammer_contact_s()?))),
    ("the key leaves its punching by", "mm", |run| {
        let met = run.time_s.partition_point(|&t| run.events.key_bottom_s.is_none_or(|bottom_s| t < bottom_s));
        let met_m = *run.key_m.get(met)?;
        Some(1e3 * (met_m - run.key_m[met..].iter().copied().fold(met_m, f64::min)))
    }),
    ("the hammer ends above its rest", "mm", |run| run.hammer_rise_m.last().map(|m| 1e3 * m)),
];

fn after_start_ms(run: &Run, at_s: Option<f64>) -> Option<f64> {
    Some(1e3 * (at_s? - run.events.key_start_s?))
}

/// Spread of a result over the inputs.
struct Spread {
    /// Quantiles at 5 %, 50 % and 95 %.
    quantiles: [f64; 3],
    /// Largest difference between neighbouring inputs over the spread from 5 to 95 %.
    jump: f64,
    came_about: usize,
}

impl Spread {
    fn of(values: &[Option<f64>]) -> Self {
        let mut sorted: Vec<f64> = values.iter().flatten().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let came_about = sorted.len();
        let at = |share: f64| sorted.get((share * came_about.saturating_sub(1) as f64).round() as usize);
        let quantiles = [0.05, 0.5, 0.95].map(|share| at(share).copied().unwrap_or(f64::NAN));
        let steps = values.windows(2).filter_map(|pair| Some((pair[1]? - pair[0]?).abs()));
        let jump = steps.fold(0.0, f64::max) / (quantiles[2] - quantiles[0]);
        Spread { quantiles, jump, came_about }
    }

    /// Spread from 5 to 95 % over the median.
    fn relative(&self) -> f64 {
        (self.quantiles[2] - self.quantiles[0]) / self.quantiles[1]
    }
}

/// Computes results over a hundredth of the force.
fn scatter(
    instrument: &Instrument,
    levels: &[Played],
    section: &mut Section,
    progress: &mut Progress,
) -> Result<(), ReproduceError> {
    let header = ["level", "result", "5 %", "middle", "95 %", "", "jump / spread", "notes"];
    let mut table = Table::new(format!("Results of {DRAWS} notes over a hundredth of the force"), &header);
    let mut curves = [const { Vec::new() }; RESULTS.len() - UP_TO_IMPACT];
    let (mut smooth, mut roughest, mut later) = (0.0_f64, 0.0_f64, Vec::new());
    for (n, played) in levels.iter().enumerate() {
        let factors: Vec<f64> = (0..DRAWS).map(|k| 1.0 + INPUT * (k as f64 / (DRAWS - 1) as f64 - 0.5)).collect();
        let mut runs = Vec::with_capacity(DRAWS);
        for (k, factor) in factors.iter().enumerate() {
            tell(progress, (n as f64 + k as f64 / DRAWS as f64) / levels.len() as f64)?;
            let run = played.run(instrument, &played.with(*factor), STEPS.0, KEPT)?;
            runs.push(RESULTS.map(|(_, _, of)| of(&run)));
        }
        for (result, (name, unit, _)) in RESULTS.iter().enumerate() {
            let values: Vec<Option<f64>> = runs.iter().map(|run| run[result]).collect();
            let spread = Spread::of(&values);
            let [low, middle, high] = spread.quantiles.map(|value| shown(value, 3));
            table.row([
                played.name.to_owned(),
                (*name).to_owned(),
                low.clone(),
                middle.clone(),
                high.clone(),
                (*unit).to_owned(),
                shown(spread.jump, 2),
                spread.came_about.to_string(),
            ]);
            if result < UP_TO_IMPACT {
                smooth = smooth.max(spread.relative());
            } else if spread.came_about > 0 {
                roughest = roughest.max(spread.jump);
                later.push(format!("{}: {name} {low} to {high} {unit}", played.name));
                let (x, y) = factors.iter().zip(values).filter_map(|(f, v)| Some((100.0 * (f - 1.0), v?))).unzip();
                curves[result - UP_TO_IMPACT].push(ChartCurve {
                    label: played.name.into(),
                    x,
                    y,
                    colour: n,
                    mark: Dash::Points,
                });
            }
        }
    }
    section.tables.push(table);
    let panels = RESULTS[UP_TO_IMPACT..].iter().zip(curves).map(|((name, unit, _), curves)| ChartPanel {
        y_label: format!("{name} ({unit})"),
        y_log: false,
        y_range: None,
        curves,
    });
    section.charts.push(Chart {
        title: "After the impact, over the force".into(),
        caption: format!("{DRAWS} notes of each level, whose forces differ by a hundredth as a whole"),
        x_label: "force of the hand's muscle (% off)".into(),
        x_log: false,
        panels: panels.collect(),
    });
    section.claims.push(Claim::new(
        "this program",
        "up to the impact and the key's bottom a hundredth of the force changes no result by more than two hundredths",
        format!("{:.1} % at most", 100.0 * smooth),
        smooth < 2.0 * INPUT,
    ));
    section.claims.push(Claim::new(
        "this program",
        "after the impact, too, results follow the force smoothly: none is left to chance",
        format!("neighbours differ by {:.0} % of a spread at most; {}", 100.0 * roughest, later.join("; ")),
        roughest < SMOOTH,
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors that fall as h^2 have order 2; a ramp has its quantiles, and its steps are a two-hundredth of it.
    #[test]
    fn closed_forms() {
        let steps = halvings(1.0, 5);
        let squares: Vec<f64> = steps.iter().map(|h| 3.0 * h * h).collect();
        assert!((order(&steps, &squares) - 2.0).abs() < 1e-12);
        let ramp: Vec<Option<f64>> = (0..=200).map(|k| Some(f64::from(k))).collect();
        let spread = Spread::of(&ramp);
        assert_eq!(spread.quantiles, [10.0, 100.0, 190.0]);
        assert!((spread.jump - 1.0 / 180.0).abs() < 1e-12 && spread.came_about == 201);
    }
}
