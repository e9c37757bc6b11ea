//! Derivatives of a press compared with differences of presses with converged steps.

use std::time::Instant;

use erard::gradient::QUANTITIES;
use erard::level::{HandKind, MASS_KG, Reference, named};
use erard::parameter::Parameter;
use erard::player::Input;
use erard::stroke::{HandStroke, Touch};
use erard::{Action, Instrument, Settings, Setup};
use erard_workshop::sensitivities::{Differentiation, Gradient, Rest, SHORTER, Variable, gradient};
use erard_workshop::study::{Job, JobResult, OUTCOMES, Stroke, Workers, play_all};

/// Levels of the comparison.
pub const LEVELS: [&str; 3] = ["pp", "mf", "ff"];
/// Quantities of the comparison.
pub const OF: [&str; 2] = ["hammer_speed_m_per_s", "hammer_contact_s"];
/// Step for the timing of both, s: Python's default.
const TIMED_S: f64 = 25e-6;
/// Steps of the differences, s; the differentiated press uses the longer one. At ff differences in steps of 5 and 2.5
/// us agree with each other on wrong values ([`trap`]).
fn converged_s(level: &str) -> [f64; 2] {
    if level == "ff" { [1.25e-6, 0.625e-6] } else { [5e-6, 2.5e-6] }
}
/// Half the windows of the differences, as shares of a number's usual change; each is [`WIDER`] times the one before.
/// They are wide, because over a narrow one no switch of friction moves by a whole step, and differences of fixed steps
/// then show what a step in dual numbers shows, which is wrong (the engine's README, "Derivatives").
const WINDOWS: [f64; 4] = [0.05, 0.2, 0.8, 3.2];
/// See [`WINDOWS`].
const WIDER: f64 = 4.0;
/// Half the windows, as shares of the usual change, and the steps, s, in which rows that are apart are looked at again.
const AGAIN: [f64; 5] = [0.0125, 0.05, 0.2, 0.8, 3.2];
const SHORTEST_S: f64 = 0.625e-6;
/// Derivative and differences agree within this share.
const SHARE: f64 = 0.02;
/// A number has no visible effect if its usual change moves a result by less than this share.
const UNSEEN: f64 = 1e-5;
/// Duration after the impact of the unchanged action, s.
const AFTER_S: f64 = 4e-3;

/// Agreement of a derivative with differences.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// They differ by at most [`SHARE`].
    Within,
    /// They differ by more, but by no more than the differences among themselves.
    Scatter,
    /// They differ by more than that.
    Apart,
    /// The call refuses the derivative.
    Refused,
    /// The number has no visible effect.
    NoEffect,
}

/// A derivative and differences, per usual change of the number.
#[derive(Debug, Clone)]
pub struct Row {
    pub of: &'static str,
    pub by: String,
    pub derivative: f64,
    /// Derivative in shorter steps.
    pub shorter: f64,
    pub differences: f64,
    /// Change of the differences between two windows, plus that between two steps.
    pub scatter: f64,
    /// Differences downward and upward, in the shorter steps.
    pub sides: [f64; 2],
    /// In steps of [`SHORTEST_S`], of a row that is apart: the differences, and over the narrowest windows those to
    /// below and to above.
    pub again: f64,
    pub narrowest: [[f64; 2]; 3],
    /// Half the window, as a share of the usual change.
    pub window: f64,
    pub verdict: Verdict,
}

impl Row {
    /// Distance of the two, as a share of the differences.
    pub fn apart(&self) -> f64 {
        (self.derivative - self.differences).abs() / self.differences.abs()
    }

    /// Reason of the disagreement, as far as the numbers show it.
    pub fn reason(&self) -> &'static str {
        let is_middle = |[below, above]: &[f64; 2]| {
            let middle = 0.5 * (below + above);
            (self.derivative - middle).abs() <= SHARE * middle.abs()
        };
        let is_between = |[below, above]: &[f64; 2]| (below.min(*above)..=below.max(*above)).contains(&self.derivative);
        // Of a derivative whose error is in proportion to the step h, 0.2 of the error goes with 0.2 h.
        let own_error = (self.derivative - self.shorter).abs() / (1.0 - SHORTER);
        if self.derivative.is_nan() {
            "refused"
        } else if (self.derivative - self.again).abs() <= SHARE * self.again.abs() {
            "the differences' own steps: within 2 % in steps of 0.625 us"
        } else if self.narrowest.iter().any(is_middle) {
            "curved: within 2 % over a narrow window"
        } else if self.narrowest.iter().any(is_between) {
            "a corner within a narrow window: between the slopes to its sides"
        } else if own_error >= 0.5 * (self.derivative - self.differences).abs() {
            "the derivative's own steps"
        } else {
            "not known"
        }
    }
}

/// Beginning of a row in the note's list of disagreements.
pub fn line(level: &str, row: &Row) -> String {
    format!("| {level} | `{}` | `{}` |", row.of, row.by)
}

/// The numbers of the first cases.
pub const FIRST: [&str; 3] = ["body.jack.friction", "body.hammer.friction", "body.key.friction"];
/// Of one number: derivative and differences of hammer speed, m/s per factor, with a moving rest, and with a held one.
pub type First = [[f64; 2]; 2];

/// First cases: frictions of the rigid grand under 5 N, over windows of 1 %.
pub fn first_cases() -> [First; 3] {
    const HALF: f64 = 1e-2;
    let instrument = Instrument::builtin("concert-grand-rigid").unwrap();
    let parameters = Parameter::all(&instrument);
    let rest = Action::new(&instrument).unwrap().mechanism().save();
    let speed = |name: &str, by: f64, held: bool| {
        let (_, parameter) = parameters.iter().find(|(known, _)| known == name).unwrap();
        let mut varied = instrument.clone();
        parameter.vary(&mut varied, 1.0 + by).unwrap();
        let mut action = Action::with(&varied, Settings::new(5e-6)).unwrap();
        if held {
            action.mechanism_mut().restore(&rest);
            action.set_reference_pose(&varied);
        }
        while action.impact().is_none() {
            assert!(action.time_s() < 0.2, "{name} {by}");
            action.step(Input::Force(5.0));
        }
        action.impact().unwrap().hammer_speed_m_per_s
    };
    let by: Vec<Variable> = FIRST.iter().map(|name| Variable::named(&instrument, "", name).unwrap()).collect();
    let stroke = || -> Stroke<'static> { Box::new(move |_| Input::Force(5.0)) };
    let setup = Setup { settings: Settings::new(TIMED_S), ledger: false, ..Setup::new(0.2) };
    let found = [Rest::Moves, Rest::Held].map(|rest| {
        let how = Differentiation { rest, of: vec![OF[0].to_owned()], ..compared() };
        gradient(&instrument, by.clone(), &stroke, &setup, how, &mut |_| true).unwrap()
    });
    core::array::from_fn(|k| {
        [0, 1].map(|which| {
            let derived = found[which].of[0].1.as_ref().unwrap().slopes[k];
            let held = which == 1;
            [derived, (speed(FIRST[k], HALF, held) - speed(FIRST[k], -HALF, held)) / (2.0 * HALF)]
        })
    })
}

/// Compares steps of two lengths, on all cores.
fn compared() -> Differentiation {
    Differentiation {
        rest: Rest::Moves,
        sample_every: None,
        compares: true,
        refuses: false,
        of: OF.map(str::to_owned).to_vec(),
        threads: erard_workshop::cores::count(),
    }
}

/// A level: its rows, and computing times.
pub struct Level {
    pub name: &'static str,
    pub rows: Vec<Row>,
    /// Processor time of one core for all derivatives, with one step length, s.
    pub gradient_s: f64,
    /// Processor time of one core for central differences in lanes with the same step, s.
    pub differences_s: f64,
}

/// The instrument's numbers, as variables of derivatives and as parameters of studies.
struct Numbers {
    variables: Vec<Variable>,
    parameters: Vec<Parameter>,
}

impl Numbers {
    fn of(instrument: &Instrument) -> Self {
        let variables = Variable::all(instrument);
        let all = Parameter::all(instrument);
        let known = |one: &Variable| all.iter().find(|(name, _)| *name == one.name).map(|(_, found)| found.clone());
        let parameters = variables.iter().filter_map(known).collect();
        Numbers { variables, parameters }
    }

    /// Usual change of a number, as a bare number.
    fn usual(&self, k: usize) -> f64 {
        self.variables[k].usual / self.variables[k].per_bare_number()
    }

    /// An instrument with one number changed by `by` usual changes.
    fn varied(&self, instrument: &Instrument, k: usize, by: f64) -> Instrument {
        let (mut varied, by) = (instrument.clone(), by * self.usual(k));
        let value = if self.parameters[k].is_factor() { 1.0 + by } else { by };
        self.parameters[k]
            .vary(&mut varied, value)
            .unwrap_or_else(|error| panic!("{}: {error}", self.variables[k].name));
        varied
    }
}

/// Plays the stroke on instruments, in lanes.
fn play(instruments: &[Instrument], hand: &HandStroke, setup: &Setup, workers: Workers) -> Vec<JobResult> {
    let stroke = || -> Stroke<'static> {
        let hand = *hand;
        Box::new(move |t| -> Input { hand.input(t) })
    };
    let jobs = (0..instruments.len()).map(|instrument| Job { instrument, stroke: stroke() });
    play_all(instruments, jobs.collect(), setup, workers, &mut |_| true).unwrap()
}

fn value(played: &JobResult, key: &str) -> f64 {
    let (_, of) = OUTCOMES.iter().find(|(name, _)| *name == key).unwrap();
    played.as_ref().ok().and_then(of).unwrap_or(f64::NAN)
}

/// A press at a level.
struct Press<'a> {
    instrument: &'a Instrument,
    hand: HandStroke,
    impact_s: f64,
    numbers: Numbers,
}

impl<'a> Press<'a> {
    fn new(instrument: &'a Instrument, name: &str) -> Self {
        let kind = HandKind::new(Touch::Pressed, MASS_KG);
        let solved = Reference::new(instrument, &mut |_| true)
            .and_then(|mut reference| reference.solve(kind, named(name).unwrap(), &mut |_| true));
        let solved = solved.unwrap();
        let (hand, impact_s) = (solved.held(), solved.impact.time_s);
        Press { instrument, hand, impact_s, numbers: Numbers::of(instrument) }
    }

    fn setup(&self, step_s: f64) -> Setup {
        Setup {
            settings: Settings::new(step_s),
            ledger: false,
            hand: Some(self.hand.hand),
            ..Setup::new(self.impact_s + AFTER_S)
        }
    }

    fn derived(&self, by: Vec<Variable>, step_s: f64, how: Differentiation) -> Gradient {
        let hand = self.hand;
        let stroke = || -> Stroke<'static> { Box::new(move |t| hand.input(t)) };
        gradient(self.instrument, by, &stroke, &self.setup(step_s), how, &mut |_| true).unwrap()
    }

    /// Plays one number's variants; returns the differences of a result to below and to above, window by window.
    fn sides<const N: usize>(&self, k: usize, of: &str, windows: &[f64; N], step_s: f64) -> [[f64; 2]; N] {
        let own = self.instrument;
        let changed = windows.iter().flat_map(|&window| [-window, window].map(|by| self.numbers.varied(own, k, by)));
        let instruments: Vec<Instrument> = std::iter::once(own.clone()).chain(changed).collect();
        let played = self.played(&instruments, step_s, Workers::all());
        core::array::from_fn(|n| {
            let [own, low, high] = [0, 2 * n + 1, 2 * n + 2].map(|place| value(&played[place], of));
            [(own - low) / windows[n], (high - own) / windows[n]]
        })
    }

    fn played(&self, instruments: &[Instrument], step_s: f64, workers: Workers) -> Vec<JobResult> {
        play(instruments, &self.hand, &self.setup(step_s), workers)
    }
}

/// Numbers whose differences in steps that are too long agree with each other, but are wrong.
pub const TRAPPED: [&str; 4] =
    ["zone.let_off_button.damping", "zone.capstan_heel.damping", "spring.repetition.torque", "body.jack.mass"];
/// Steps for these, s.
pub const TRAP_S: [f64; 4] = [5e-6, 2.5e-6, 1.25e-6, 0.625e-6];
/// Half the window, in usual changes.
const TRAP: f64 = 0.2;

/// Derivatives and central differences of hammer speed at ff for [`TRAPPED`], m/s per usual change, at [`TRAP_S`].
pub fn trap(instrument: &Instrument) -> [[[f64; 2]; 4]; 4] {
    let instrument = &instrument.clone().without_outlines();
    let press = Press::new(instrument, "ff");
    let numbers = &press.numbers;
    let places = TRAPPED.map(|name| numbers.variables.iter().position(|one| one.name == name).unwrap());
    let both: Vec<Instrument> =
        places.iter().flat_map(|&k| [-TRAP, TRAP].map(|by| numbers.varied(instrument, k, by))).collect();
    let found = TRAP_S.map(|step_s| {
        let by = places.map(|k| numbers.variables[k].clone()).to_vec();
        let derived = press.derived(by, step_s, Differentiation { compares: false, ..compared() });
        let slopes = derived.of.into_iter().find(|(key, _)| *key == OF[0]).unwrap().1.unwrap().slopes;
        let played = press.played(&both, step_s, Workers::all());
        core::array::from_fn(|n| {
            let [low, high] = [2 * n, 2 * n + 1].map(|place| value(&played[place], OF[0]));
            [slopes[n] * numbers.usual(places[n]), (high - low) / (2.0 * TRAP)]
        })
    });
    core::array::from_fn(|n| found.map(|of: [[f64; 2]; 4]| of[n]))
}

/// Windows over which one number is looked at closely, as shares of its usual change.
const CLOSE: [f64; 9] = [0.0125, 0.025, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2];

/// One number's slopes of a result, per usual change.
pub struct Closely {
    pub step_s: f64,
    pub derivative: f64,
    /// Half the window as a share of the usual change, and the differences to below and to above.
    pub differences: Vec<(f64, [f64; 2])>,
}

/// Looks at one number closely: derivatives in steps of several lengths, and differences over many windows in each.
pub fn closely(instrument: &Instrument, name: &str, of: &str, by: &str) -> Vec<Closely> {
    let instrument = &instrument.clone().without_outlines();
    let press = Press::new(instrument, name);
    let numbers = &press.numbers;
    let k = numbers.variables.iter().position(|one| one.name == by).expect("a number of the instrument");
    let look = |step_s: f64| {
        let by = vec![numbers.variables[k].clone()];
        let derived = press.derived(by, step_s, Differentiation { compares: false, ..compared() });
        let (_, derived) = derived.of.into_iter().find(|(key, _)| *key == of).expect("a result that is compared");
        let differences = CLOSE.into_iter().zip(press.sides(k, of, &CLOSE, step_s)).collect();
        Closely { step_s, derivative: derived.unwrap().slopes[0] * numbers.usual(k), differences }
    };
    TRAP_S.into_iter().map(look).collect()
}

/// Compares all derivatives of an instrument's press at a level.
pub fn level(instrument: &Instrument, name: &'static str) -> Level {
    let instrument = &instrument.clone().without_outlines();
    let press = Press::new(instrument, name);
    let numbers = &press.numbers;
    let find = |step_s: f64, how: Differentiation| press.derived(numbers.variables.clone(), step_s, how);
    let steps_s = converged_s(name);
    let found = find(steps_s[0], compared());
    let begun = Instant::now();
    find(TIMED_S, Differentiation { compares: false, threads: 1, ..compared() });
    let gradient_s = begun.elapsed().as_secs_f64();

    let count = numbers.variables.len();
    let pairs = |window: f64| {
        let both = (0..count).flat_map(|k| [-window, window].map(|by| (k, by)));
        both.map(|(k, by)| numbers.varied(instrument, k, by)).collect::<Vec<_>>()
    };
    let begun = Instant::now();
    press.played(&pairs(TRAP), TIMED_S, Workers::one());
    let differences_s = begun.elapsed().as_secs_f64();

    // For every window and step: the unchanged action, then two variants per number.
    let played = WINDOWS.map(|window| {
        let instruments: Vec<Instrument> = std::iter::once(instrument.clone()).chain(pairs(window)).collect();
        steps_s.map(|step_s| press.played(&instruments, step_s, Workers::all()))
    });
    let mut rows = Vec::new();
    for of in OF {
        for k in 0..count {
            let windows = WINDOWS.each_ref().map(|window| {
                let place = WINDOWS.iter().position(|one| one == window).unwrap();
                played[place].each_ref().map(|all| {
                    let [own, low, high] = [0, 2 * k + 1, 2 * k + 2].map(|place| value(&all[place], of));
                    [(own - low) / window, (high - own) / window]
                })
            });
            rows.push(row(&found, of, k, numbers, &Sides::best(&windows, &WINDOWS)));
        }
    }
    look_again(&press, &mut rows);
    Level { name, rows, gradient_s, differences_s }
}

/// Plays the rows that are apart in the shortest steps.
fn look_again(press: &Press, rows: &mut [Row]) {
    for row in rows.iter_mut().filter(|row| matches!(row.verdict, Verdict::Apart | Verdict::Refused)) {
        let k = press.numbers.variables.iter().position(|one| one.name == row.by).unwrap();
        let slopes = press.sides(k, row.of, &AGAIN, SHORTEST_S);
        row.again = Sides::best(&slopes.map(|of| [of; 2]), &AGAIN).slope;
        row.narrowest = [slopes[0], slopes[1], slopes[2]];
    }
}

/// Differences over two windows in two steps, per usual change.
struct Sides {
    /// Extrapolated from the two windows to zero width, in the shorter steps.
    slope: f64,
    /// Change between the two windows, plus that between the two steps.
    scatter: f64,
    /// One-sided differences over the narrower window, in the shorter steps.
    sides: [f64; 2],
    window: f64,
}

impl Sides {
    /// From the slopes over all windows: the widest pair of windows whose differences are one within [`SHARE`], over
    /// both steps, else the one that agrees best.
    fn best(slopes: &[[[f64; 2]; 2]], windows: &[f64]) -> Self {
        let pairs: Vec<Sides> = slopes.windows(2).zip(windows).map(|(pair, window)| Sides::of(pair, *window)).collect();
        let widest = pairs.iter().rposition(|one| one.scatter <= SHARE * one.slope.abs());
        let best = || (0..pairs.len()).min_by(|a, b| pairs[*a].scatter.total_cmp(&pairs[*b].scatter));
        let place = widest.or_else(best).expect("two windows");
        pairs.into_iter().nth(place).expect("it is one of them")
    }

    /// From the slopes to below and to above in two steps, over a window and a wider one.
    fn of(pair: &[[[f64; 2]; 2]], window: f64) -> Self {
        let middle = |[below, above]: [f64; 2]| 0.5 * (below + above);
        let [near, far] = [pair[0].map(middle), pair[1].map(middle)];
        let slope = |step: usize| near[step] + (near[step] - far[step]) / (WIDER * WIDER - 1.0);
        let scatter = (near[1] - far[1]).abs() + (slope(1) - slope(0)).abs();
        Sides { slope: slope(1), scatter, sides: pair[0][1], window }
    }
}

fn row(found: &Gradient, of: &'static str, k: usize, numbers: &Numbers, sides: &Sides) -> Row {
    let place = QUANTITIES.iter().position(|(key, _)| *key == of).unwrap();
    let derived = found.of[place].1.as_ref().unwrap();
    let usual = numbers.usual(k);
    let (differences, scatter) = (sides.slope, sides.scatter);
    let [derivative, shorter] = [derived.slopes[k], derived.in_shorter_steps[k]].map(|slope| slope * usual);
    let apart = (derivative - differences).abs();
    let verdict = if derivative.is_nan() {
        Verdict::Refused
    } else if derivative.abs().max(differences.abs()) < UNSEEN * derived.value.abs() {
        Verdict::NoEffect
    } else if apart <= SHARE * differences.abs() {
        Verdict::Within
    } else if apart <= scatter {
        Verdict::Scatter
    } else {
        Verdict::Apart
    };
    let by = numbers.variables[k].name.clone();
    Row {
        of,
        by,
        derivative,
        shorter,
        differences,
        scatter,
        sides: sides.sides,
        again: f64::NAN,
        narrowest: [[f64::NAN; 2]; 3],
        window: sides.window,
        verdict,
    }
}
