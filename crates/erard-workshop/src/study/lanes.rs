//! Mechanisms side by side: brought to rest, and played.

use moreau::{Input, Model, ModelError, Outcome, Pose, Settings, State};
use moreau_lanes::{Group, Lanes};

use super::reach::{Reach, lever};
use super::{JobResult, Played, Stroke};
use crate::cores::Interrupt;
use erard::assembly::{assemble, drawn_angles};
use erard::course::Rest;
use erard::equilibrium::{self, EquilibriumError, PATIENCE_S, Settling};
use erard::events::Watch;
use erard::instrument::Instrument;
use erard::mechanism::mechanism;
use erard::sight::{Sight, Visible, head_height};
use erard::simulation::{Setup, SimulationError};

/// Every so many steps the caller is asked whether to go on.
const ASK_EVERY: u64 = 1024;

/// An instrument assembled, undriven and at rest.
pub(super) struct AtRest<const B: usize, const Z: usize> {
    model: Model<f64, B, Z>,
    state: State<f64, B, Z>,
}

/// The same, or why there is none.
pub(super) type Rested<const B: usize, const Z: usize> = Result<AtRest<B, Z>, EquilibriumError>;

/// What is played in one lane.
pub(super) struct Player<'a, const B: usize, const Z: usize> {
    pub instrument: &'a Instrument,
    pub rest: &'a Rested<B, Z>,
    pub stroke: Stroke<'a>,
}

/// A group of the mechanisms of some lanes; where there are fewer than lanes, the last one is there several times.
fn group<const B: usize, const Z: usize, const N: usize>(
    mut models: Vec<Model<f64, B, Z>>,
    mut states: Vec<State<f64, B, Z>>,
    settings: &Settings<f64>,
    lanes: Lanes,
) -> Group<B, Z, N> {
    let fill = |count: usize| lanes.count().saturating_sub(count);
    models.extend(models.last().cloned().map(|last| vec![last; fill(models.len())]).unwrap_or_default());
    states.extend(states.last().cloned().map(|last| vec![last; fill(states.len())]).unwrap_or_default());
    Group::new(&models, &states, settings, lanes)
}

/// Inputs for all lanes of a group: the last one for those that are filled up.
fn inputs_of(own: impl Iterator<Item = Input<f64>>, inputs: &mut [Input<f64>]) {
    let mut from = 0;
    for (i, input) in own.enumerate() {
        inputs[i] = input;
        from = i;
    }
    let last = inputs[from];
    inputs[from..].fill(last);
}

/// Brings instruments of one topology to rest.
///
/// # Errors
/// [`SimulationError::Interrupted`].
pub(super) fn settle<const B: usize, const Z: usize, const N: usize>(
    instruments: &[&Instrument],
    settings: Settings<f64>,
    lanes: Lanes,
    going: Interrupt<'_>,
) -> Result<Vec<Rested<B, Z>>, SimulationError> {
    let models: Vec<Result<Model<f64, B, Z>, ModelError>> = instruments.iter().map(|i| assemble(i)).collect();
    let Some(stand_in) = models.iter().flatten().next().cloned() else {
        return Ok(models.into_iter().filter_map(Result::err).map(|error| Err(error.into())).collect());
    };
    let own = models.iter().map(|model| model.as_ref().unwrap_or(&stand_in).clone()).collect();
    let drawn = instruments.iter().map(|instrument| State::at_rest(drawn_angles(instrument))).collect();
    let free = vec![Input::Free; instruments.len()];
    let states = come_to_rest::<B, Z, N>(own, drawn, &free, lanes, going)?;
    let each = instruments.iter().zip(models).zip(states);
    let rested = each.map(|((instrument, model), state)| {
        let model = model?;
        let state = state.map_or_else(|| alone(instrument, settings, 0.0), Ok)?;
        Ok(AtRest { model, state })
    });
    Ok(rested.collect())
}

/// Steps mechanisms until they rest, as [`equilibrium::settle`] does; `None` for one that it would have to slow down, or that flies
/// apart.
fn come_to_rest<const B: usize, const Z: usize, const N: usize>(
    models: Vec<Model<f64, B, Z>>,
    from: Vec<State<f64, B, Z>>,
    own_inputs: &[Input<f64>],
    lanes: Lanes,
    going: Interrupt<'_>,
) -> Result<Vec<Option<State<f64, B, Z>>>, SimulationError> {
    let count = models.len();
    let mut group = group::<B, Z, N>(models, from, &equilibrium::settings(), lanes);
    let mut inputs = vec![Input::Free; lanes.count().max(count)];
    inputs_of(own_inputs.iter().copied(), &mut inputs);
    let mut outcomes = vec![Outcome::Converged; inputs.len()];
    let mut rested: Vec<Option<State<f64, B, Z>>> = vec![None; count];
    let (mut settling, mut waited_for) = (vec![Settling::default(); count], vec![true; count]);
    let mut steps = 0_u64;
    while waited_for.contains(&true) {
        if steps.is_multiple_of(ASK_EVERY) && !going() {
            return Err(SimulationError::Interrupted);
        }
        steps += 1;
        group.step(&inputs, &mut outcomes);
        for i in 0..count {
            if !waited_for[i] {
                continue;
            }
            if outcomes[i] == Outcome::NonFinite {
                waited_for[i] = false;
            } else if settling[i].rests(&group.motion(i).1) {
                let mut state = group.state(i);
                state.velocity = [0.0; B];
                rested[i] = Some(state);
                waited_for[i] = false;
            } else if settling[i].time_s > PATIENCE_S {
                waited_for[i] = false;
            }
        }
    }
    Ok(rested)
}

/// Brings one instrument to rest by itself, first undriven and then, if it begins there, under a finger so far down.
fn alone<const B: usize, const Z: usize>(
    instrument: &Instrument,
    settings: Settings<f64>,
    begins_at_m: f64,
) -> Result<State<f64, B, Z>, EquilibriumError> {
    let mut m = mechanism(instrument, settings)?;
    equilibrium::settle(m.as_mut(), instrument, &Input::Free, &mut || true)?;
    if begins_at_m > 0.0 {
        let position = m.site_position() + begins_at_m;
        equilibrium::settle(m.as_mut(), instrument, &Input::Motion { position, velocity: 0.0 }, &mut || true)?;
    }
    let of = |values: &[f64]| std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0));
    let mut state = State::at_rest(of(m.angles()));
    state.pivot_friction = of(m.pivot_friction());
    Ok(state)
}

/// One lane while it is played.
struct Lane<'a, const B: usize, const Z: usize> {
    player: &'a Player<'a, B, Z>,
    model: &'a Model<f64, B, Z>,
    at_rest: &'a State<f64, B, Z>,
    pose: Pose<f64, B>,
    velocity: [f64; B],
    rest: Rest,
    watch: Watch,
    highest_m: f64,
    unconverged_steps: u64,
    failed: Option<SimulationError>,
    /// The hammer's lever, where a step may go unseen.
    lever: Option<(usize, f64)>,
    /// Set while nothing can happen; the last moments that were not looked at, then.
    idle: Option<Reach>,
    missed: [Option<Moment<B>>; 2],
}

/// Where a mechanism is at an instant.
#[derive(Clone, Copy)]
struct Moment<const B: usize> {
    time_s: f64,
    angle: [f64; B],
    velocity: [f64; B],
}

impl<'a, const B: usize, const Z: usize> Lane<'a, B, Z> {
    fn new(player: &'a Player<'a, B, Z>) -> Result<Self, SimulationError> {
        let AtRest { model, state } = player.rest.as_ref().map_err(Clone::clone)?;
        if player.instrument.roles.key.is_none() && !matches!(player.stroke, Stroke::Free) {
            return Err(SimulationError::NoKey);
        }
        let mut lane = Lane {
            player,
            model,
            at_rest: state,
            pose: Pose::of(model, &state.angle),
            velocity: state.velocity,
            rest: Rest { site_m: 0.0, head_m: 0.0 },
            watch: Watch::new(player.instrument),
            highest_m: 0.0,
            unconverged_steps: 0,
            failed: None,
            // An imposed motion asks for the pose in every step.
            lever: lever(player.instrument).filter(|_| !matches!(player.stroke, Stroke::Rigid(_))),
            idle: None,
            missed: [None; 2],
        };
        lane.rest = Rest::of(player.instrument, &lane.sight());
        Ok(lane)
    }

    fn sight(&self) -> Sight<'_, B, Z> {
        Sight { model: self.model, pose: &self.pose, velocity: &self.velocity }
    }

    /// Looks at the mechanism where it is now. While nothing can happen it looks away, and when something can again, it first sees
    /// the two moments just before: what is seen to happen is the same as if it had never looked away.
    fn look(&mut self, time_s: f64, (angle, velocity): ([f64; B], [f64; B])) {
        let now = Moment { time_s, angle, velocity };
        if let Some(reach) = self.idle {
            if reach.is_out(&angle) {
                self.missed = [self.missed[1], Some(now)];
                return;
            }
            for moment in std::mem::take(&mut self.missed).into_iter().flatten() {
                self.see(moment);
            }
        }
        self.see(now);
        self.idle = match (self.lever, self.player.instrument.roles.string) {
            (Some(lever), Some(string)) if self.watch.sees_blows_only() => {
                Reach::of(lever, &angle, self.sight().gap(string))
            }
            _ => None,
        };
    }

    fn see(&mut self, Moment { time_s, angle, velocity }: Moment<B>) {
        self.pose = Pose::of(self.model, &angle);
        self.velocity = velocity;
        let sight = Sight { model: self.model, pose: &self.pose, velocity: &self.velocity };
        let key_m = sight.site_position() - self.rest.site_m;
        let hammer_m = head_height(self.player.instrument, &sight) - self.rest.head_m;
        self.watch.look(time_s, key_m, hammer_m, &sight);
        self.highest_m = self.highest_m.max(hammer_m);
    }

    /// The input of the step from t0; of a mechanism that has failed, one of the same kind that does no harm.
    fn input(&self, t0: f64, settings: &Settings<f64>) -> Input<f64> {
        if self.failed.is_none() {
            let Settings { step: h, theta, .. } = *settings;
            return self.rest.input(&self.player.stroke.drive(), t0, h, theta, h, &|| self.sight().site_position());
        }
        match self.player.stroke {
            Stroke::Free => Input::Free,
            Stroke::Force(_) => Input::Force(0.0),
            Stroke::Motion(_) => Input::Motion { position: self.rest.site_m, velocity: 0.0 },
            Stroke::Rigid(_) => Input::Rigid { velocity: 0.0 },
        }
    }

    fn finish(self) -> JobResult {
        match self.failed {
            Some(error) => Err(error),
            None => Ok(Played {
                events: self.watch.finish(),
                highest_m: self.highest_m,
                unconverged_steps: self.unconverged_steps,
            }),
        }
    }
}

/// Plays strokes side by side, all of one kind on one topology, at most as many as there are lanes.
///
/// # Errors
/// [`SimulationError::Interrupted`].
pub(super) fn play<const B: usize, const Z: usize, const N: usize>(
    players: &[Player<'_, B, Z>],
    setup: &Setup,
    lanes: Lanes,
    going: Interrupt<'_>,
) -> Result<Vec<JobResult>, SimulationError> {
    let mut begun: Vec<Result<Lane<B, Z>, SimulationError>> = players.iter().map(Lane::new).collect();
    let mut own: Vec<&mut Lane<B, Z>> = begun.iter_mut().flatten().collect();
    if !own.is_empty() {
        step_all::<B, Z, N>(&mut own, setup, lanes, going)?;
    }
    Ok(begun.into_iter().map(|lane| lane.and_then(Lane::finish)).collect())
}

/// Steps mechanisms side by side to the end of their strokes.
fn step_all<const B: usize, const Z: usize, const N: usize>(
    own: &mut [&mut Lane<'_, B, Z>],
    setup: &Setup,
    lanes: Lanes,
    going: Interrupt<'_>,
) -> Result<(), SimulationError> {
    let states = first_states::<B, Z, N>(own, setup, lanes, going)?;
    let models = own.iter().map(|lane| lane.model.clone()).collect();
    let mut group = group::<B, Z, N>(models, states, &setup.settings, lanes);
    let mut inputs = vec![Input::Free; lanes.count().max(own.len())];
    let mut outcomes = vec![Outcome::Converged; inputs.len()];
    let steps = setup.check()?;
    let h = setup.settings.step;
    for (i, lane) in own.iter_mut().enumerate() {
        lane.look(setup.start_s, group.motion(i));
    }
    for n in 0..steps {
        if n.is_multiple_of(ASK_EVERY) {
            if !going() {
                return Err(SimulationError::Interrupted);
            }
            if own.iter().all(|lane| lane.failed.is_some()) {
                break;
            }
        }
        let t0 = setup.start_s + n as f64 * h;
        inputs_of(own.iter().map(|lane| lane.input(t0, &setup.settings)), &mut inputs);
        group.step_or_rest(&inputs, &mut outcomes);
        for (i, lane) in own.iter_mut().enumerate().filter(|(_, lane)| lane.failed.is_none()) {
            match outcomes[i] {
                Outcome::Converged => {}
                Outcome::IterationLimit => lane.unconverged_steps += 1,
                Outcome::NonFinite | Outcome::TooManyLaws => {
                    lane.failed = Some(SimulationError::NonFinite { time_s: t0 });
                    continue;
                }
            }
            lane.look(setup.start_s + (n + 1) as f64 * h, group.motion(i));
        }
    }
    Ok(())
}

/// Where the lanes begin: at rest, or under a finger that is already down.
fn first_states<const B: usize, const Z: usize, const N: usize>(
    own: &mut [&mut Lane<'_, B, Z>],
    setup: &Setup,
    lanes: Lanes,
    going: Interrupt<'_>,
) -> Result<Vec<State<f64, B, Z>>, SimulationError> {
    let at_rest: Vec<State<f64, B, Z>> = own.iter().map(|lane| lane.at_rest.clone()).collect();
    let begins_at_m: Vec<f64> = own.iter().map(|lane| lane.player.stroke.begins_at_m(setup.start_s)).collect();
    // They are grouped so that all begin at rest or none does.
    if begins_at_m.iter().all(|at| *at <= 0.0) {
        return Ok(at_rest);
    }
    let finger =
        |(lane, at): (&&mut Lane<B, Z>, &f64)| Input::Motion { position: lane.rest.site_m + at, velocity: 0.0 };
    let inputs: Vec<Input<f64>> = own.iter().zip(&begins_at_m).map(finger).collect();
    let models = own.iter().map(|lane| lane.model.clone()).collect();
    let settled = come_to_rest::<B, Z, N>(models, at_rest.clone(), &inputs, lanes.in_doubles(), going)?;
    let mut states = at_rest;
    for (((state, settled), lane), at) in states.iter_mut().zip(settled).zip(own).zip(begins_at_m) {
        match settled.map_or_else(|| alone(lane.player.instrument, setup.settings, at), Ok) {
            Ok(settled) => *state = settled,
            Err(error) => lane.failed = Some(error.into()),
        }
    }
    Ok(states)
}
