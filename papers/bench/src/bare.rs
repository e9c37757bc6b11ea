//! The cost beyond the engine's steps: a recorded press and the keys of a keyboard beside their bare steps.
//!
//! A *bare step* is the engine's step of the same mechanism with the same input, compiled once for its size
//! ([`moreau::step_out_of_line`]), and nothing else: no readings, no impact, no rows, no energy balance, no search for
//! the rest. The bare steps of a keyboard are those of each key while it was awake, one key after the other; steps that
//! would change no bit are left out on both sides. A recorded press leaves them out, too, but has a row for each: it is
//! compared with bare steps of which every one is taken, and with those that are not left out.

use std::hint::black_box;
use std::time::Instant;

use moreau::{Settings, SiteInput, StepOutcome};
use moreau_kernels::{Lanes, SideBySide};
use serde_json::{Value, json};

use super::grand::{MF_N, STEP_S, STEPS, described, group, note};
use super::{Effort, Timed, Times, in_turn};
use erard::Progress;
use erard::instrument::Instrument;
use erard::keyboard::tremolo::{STROKES_PER_S, TEN, Tremolo};
use erard::keyboard::{KEYS, Keys};
use erard::run::{Setup, press};

/// Times of something and of its bare steps, in turn within one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverBare {
    /// A bare step, ns.
    pub bare: Times,
    /// That step with everything around it, ns.
    pub whole: Times,
    /// Steps compared, on average in a round.
    pub steps: f64,
}

impl OverBare {
    /// Cost of a step with everything around it, in bare steps.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.whole.median / self.bare.median
    }

    /// A played, held and released note of an instrument: recorded in rows with its energy balance, the search for the
    /// rest included; and its bare steps, every one of them, or (second) without those that would change nothing.
    /// `None` where `progress` ended the work.
    ///
    /// # Panics
    /// If the instrument cannot be played.
    pub fn of_recorded_press(
        instrument: &Instrument,
        effort: &Effort,
        progress: &mut Progress<'_>,
    ) -> Option<[Self; 2]> {
        let steps = effort.steps;
        let rest = described(instrument).expect("it comes to rest");
        let setup = Setup { settings: Settings::new(STEP_S), ledger: true, ..Setup::new(steps as f64 * STEP_S) };
        let released_s = STEPS as f64 * 0.5 * STEP_S;
        let drive = |t: f64| erard::player::Input::Force(if t < released_s { MF_N } else { 0.0 });
        let alone = |go: fn(&mut dyn SideBySide, SiteInput<f64>)| {
            let mut alone = group(&[&rest], &setup.settings, Lanes::One);
            (0..steps).for_each(|n| go(alone.as_mut(), note(n)));
            black_box(alone.state(0));
        };
        let mut subjects = [
            Timed { count: steps as f64, go: Box::new(|| alone(step)) },
            Timed { count: steps as f64, go: Box::new(|| alone(step_or_rest)) },
            Timed {
                count: steps as f64,
                go: Box::new(|| {
                    black_box(press(black_box(instrument), &drive, &setup).expect("it plays"));
                }),
            },
        ];
        let times = in_turn(effort.rounds, &mut subjects, progress)?;
        let [every, moving, whole] = times[..] else { return None };
        Some([every, moving].map(|bare| OverBare { bare, whole, steps: steps as f64 }))
    }

    /// The keys of a keyboard that are awake in a tremolo of so many fingers, and their bare steps. Where a note lasts
    /// a second, a round is a stroke of the fingers. `None` where `progress` ended the work.
    ///
    /// # Panics
    /// If a key does not come to rest.
    pub fn of_keys(
        instruments: &[Instrument],
        fingers: usize,
        effort: &Effort,
        progress: &mut Progress<'_>,
    ) -> Option<Self> {
        let (rounds, ticks) = (effort.rounds, (effort.steps as f64 / STROKES_PER_S) as usize);
        let settings = Settings::new(STEP_S);
        let tremolo = || Tremolo::new(Keys::at_rest(instruments, settings).expect("keys come to rest"), fingers);
        // One is only asked which keys are awake, and plays ahead of the one that is timed.
        let (mut asked, mut timed) = (tremolo(), tremolo());
        let mut alone: Vec<_> = instruments
            .iter()
            .map(|key| group(&[&described(key).expect("it comes to rest")], &settings, Lanes::One))
            .collect();
        let mut inputs: Vec<Vec<SiteInput<f64>>> = vec![Vec::new(); alone.len()];
        let mut last = vec![SiteInput::Free; alone.len()];
        let (mut bare, mut whole, mut steps) = (Vec::new(), Vec::new(), 0);
        for round in 0..=rounds {
            if !progress(round as f64 / (rounds + 1) as f64) {
                return None;
            }
            inputs.iter_mut().for_each(Vec::clear);
            for _ in 0..ticks {
                asked.drive(&mut |key, force_n| last[key - 1] = SiteInput::Force(force_n));
                let awake = (0..inputs.len()).filter(|index| asked.keys().is_awake(index + 1).unwrap_or(false));
                awake.for_each(|index| inputs[index].push(last[index]));
                asked.keys_mut().step();
            }
            let count: usize = inputs.iter().map(Vec::len).sum();
            let start = Instant::now();
            (0..ticks).for_each(|_| {
                black_box(timed.tick());
            });
            let whole_ns = start.elapsed().as_nanos() as f64;
            let start = Instant::now();
            for (alone, inputs) in alone.iter_mut().zip(&inputs) {
                inputs.iter().for_each(|input| step_or_rest(alone.as_mut(), *input));
            }
            let bare_ns = start.elapsed().as_nanos() as f64;
            // The first round does not count: everything is touched for the first time.
            if round > 0 {
                bare.push(bare_ns / count as f64);
                whole.push(whole_ns / count as f64);
                steps += count;
            }
        }
        Some(OverBare { bare: Times::of(bare), whole: Times::of(whole), steps: steps as f64 / rounds as f64 })
    }
}

/// Measures; `None` where `progress` ended the work.
///
/// # Panics
/// If what is built in cannot be played.
pub(crate) fn measure(keys: &[Instrument], effort: &Effort, progress: &mut Progress<'_>) -> Option<Value> {
    let grand = Instrument::builtin("concert-grand").expect("built in");
    let [press, moving] = OverBare::of_recorded_press(&grand, effort, &mut |share| progress(0.2 * share))?;
    let ten = OverBare::of_keys(keys, TEN, effort, &mut |share| progress(0.2 + 0.3 * share))?;
    let all = OverBare::of_keys(keys, KEYS, effort, &mut |share| progress(0.5 + 0.5 * share))?;
    Some(json!({
        "press_bare_step_ns_median": press.bare.median,
        "press_over_bare_steps": press.ratio(),
        "press_over_bare_steps_not_left_out": moving.ratio(),
        "keyboard_key_step_ns_median": ten.whole.median,
        "keyboard_key_over_bare_step": ten.ratio(),
        "keyboard_all_keys_over_bare_step": all.ratio(),
    }))
}

/// One bare step.
fn step(alone: &mut dyn SideBySide, input: SiteInput<f64>) {
    let mut outcome = [StepOutcome::Converged];
    alone.step(&[input], &mut outcome);
    assert_ne!(outcome, [StepOutcome::NonFinite]);
}

/// One bare step, unless it would change nothing.
fn step_or_rest(alone: &mut dyn SideBySide, input: SiteInput<f64>) {
    let mut outcome = [StepOutcome::Converged];
    alone.step_or_rest(&[input], &mut outcome);
    assert_ne!(outcome, [StepOutcome::NonFinite]);
}
