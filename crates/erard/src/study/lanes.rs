//! Four mechanisms side by side: brought to rest, and played.

use batch::{Group, WIDTH};
use moreau::{Input, Model, ModelError, Outcome, Pose, Settings, State};

use super::reach::{Reach, lever};
use super::{JobResult, Played, Stroke};
use crate::assembly::{assemble, drawn_angles};
use crate::cores::Interrupt;
use crate::equilibrium::{self, EquilibriumError, PATIENCE_S, Settling};
use crate::events::Watch;
use crate::instrument::Instrument;
use crate::mechanism::mechanism;
use crate::sight::{Sight, Visible, head_height};
use crate::simulation::{Rest, Setup, SimulationError};

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

/// Brings four instruments of one topology to rest.
///
/// # Errors
/// [`SimulationError::Interrupted`].
pub(super) fn settle<const B: usize, const Z: usize, const N: usize>(
    instruments: [&Instrument; WIDTH],
    settings: Settings<f64>,
    going: Interrupt<'_>,
) -> Result<Vec<Rested<B, Z>>, SimulationError> {
    let models: Vec<Result<Model<f64, B, Z>, ModelError>> = instruments.iter().map(|i| assemble(i)).collect();
    let Some(stand_in) = models.iter().flatten().next().cloned() else {
        return Ok(models.into_iter().filter_map(Result::err).map(|error| Err(error.into())).collect());
    };
    let lanes = std::array::from_fn(|i| models[i].as_ref().unwrap_or(&stand_in).clone());
    let drawn = instruments.map(|instrument| State::at_rest(drawn_angles(instrument)));
    let states = come_to_rest::<B, Z, N>(lanes, drawn, &[Input::Free; WIDTH], going)?;
    let each = instruments.iter().zip(models).zip(states);
    let rested = each.map(|((instrument, model), state)| {
        let model = model?;
        let state = state.map_or_else(|| alone(instrument, settings, 0.0), Ok)?;
        Ok(AtRest { model, state })
    });
    Ok(rested.collect())
}

/// Steps four mechanisms until they rest, as [`equilibrium::settle`] does; `None` for one that it would have to slow down, or that
/// flies apart.
fn come_to_rest<const B: usize, const Z: usize, const N: usize>(
    models: [Model<f64, B, Z>; WIDTH],
    from: [State<f64, B, Z>; WIDTH],
    inputs: &[Input<f64>; WIDTH],
    going: Interrupt<'_>,
) -> Result<[Option<State<f64, B, Z>>; WIDTH], SimulationError> {
    let mut group = Group::<B, Z, N>::new(models, from, equilibrium::settings(), true);
    let mut rested = std::array::from_fn(|_| None);
    let (mut settling, mut waited_for) = ([Settling::default(); WIDTH], [true; WIDTH]);
    let mut steps = 0_u64;
    while waited_for.contains(&true) {
        if steps.is_multiple_of(ASK_EVERY) && !going() {
            return Err(SimulationError::Interrupted);
        }
        steps += 1;
        let outcomes = group.step(inputs);
        for i in 0..WIDTH {
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
    equilibrium::settle(m.as_mut(), &Input::Free)?;
    if begins_at_m > 0.0 {
        let position = m.site_position() + begins_at_m;
        equilibrium::settle(m.as_mut(), &Input::Motion { position, velocity: 0.0 })?;
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
    pose: Pose<f64, B>,
    velocity: [f64; B],
    rest: Rest,
    watch: Watch,
    highest_m: f64,
    unconverged_steps: u64,
    failed: Option<SimulationError>,
    /// The hammer's lever, where a step may go unseen.
    lever: Option<(usize, f64)>,
    /// Set while nothing can happen; what there was to see last, then.
    idle: Option<Reach>,
    before: Moment<B>,
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
            before: Moment { time_s: 0.0, angle: state.angle, velocity: state.velocity },
        };
        let sight = lane.sight();
        lane.rest = Rest { site_m: sight.site_position(), head_m: head_height(player.instrument, &sight) };
        Ok(lane)
    }

    fn sight(&self) -> Sight<'_, B, Z> {
        Sight { model: self.model, pose: &self.pose, velocity: &self.velocity }
    }

    /// Looks at the mechanism where it is now. While nothing can happen it looks away, and when something can again, it first sees
    /// what was just before: what is seen to happen is the same as if it had never looked away.
    fn look(&mut self, time_s: f64, (angle, velocity): ([f64; B], [f64; B])) {
        let now = Moment { time_s, angle, velocity };
        if let Some(reach) = self.idle {
            if reach.is_out(&angle) {
                self.before = now;
                return;
            }
            self.see(self.before);
        }
        self.see(now);
        self.before = now;
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
            return self.rest.input(&self.player.stroke.drive(), t0, settings.step, settings.theta, &self.sight());
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

/// Plays at most four strokes side by side, all of one kind on one topology.
///
/// # Errors
/// [`SimulationError::Interrupted`].
pub(super) fn play<const B: usize, const Z: usize, const N: usize>(
    players: &[Player<'_, B, Z>],
    setup: &Setup,
    going: Interrupt<'_>,
) -> Result<Vec<JobResult>, SimulationError> {
    let mut begun: Vec<Result<Lane<B, Z>, SimulationError>> = players.iter().map(Lane::new).collect();
    let mut lanes: Vec<&mut Lane<B, Z>> = begun.iter_mut().flatten().collect();
    if !lanes.is_empty() {
        step_all::<B, Z, N>(&mut lanes, setup, going)?;
    }
    Ok(begun.into_iter().map(|lane| lane.and_then(Lane::finish)).collect())
}

/// Steps the lanes to the end of their strokes; the places that are left over repeat the last lane.
fn step_all<const B: usize, const Z: usize, const N: usize>(
    lanes: &mut [&mut Lane<'_, B, Z>],
    setup: &Setup,
    going: Interrupt<'_>,
) -> Result<(), SimulationError> {
    let last = lanes.len() - 1;
    let models = std::array::from_fn(|i| lanes[i.min(last)].model.clone());
    let mut group = Group::<B, Z, N>::new(models, first_states::<B, Z, N>(lanes, setup, going)?, setup.settings, true);
    let steps = setup.check()?;
    let h = setup.settings.step;
    for (i, lane) in lanes.iter_mut().enumerate() {
        lane.look(setup.start_s, group.motion(i));
    }
    for n in 0..steps {
        if n.is_multiple_of(ASK_EVERY) {
            if !going() {
                return Err(SimulationError::Interrupted);
            }
            if lanes.iter().all(|lane| lane.failed.is_some()) {
                break;
            }
        }
        let t0 = setup.start_s + n as f64 * h;
        let mut inputs = [Input::Free; WIDTH];
        for (i, lane) in lanes.iter().enumerate() {
            inputs[i..].fill(lane.input(t0, &setup.settings));
        }
        let outcomes = group.step(&inputs);
        for (i, lane) in lanes.iter_mut().enumerate().filter(|(_, lane)| lane.failed.is_none()) {
            match outcomes[i] {
                Outcome::Converged => {}
                Outcome::IterationLimit => lane.unconverged_steps += 1,
                Outcome::NonFinite => {
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
    lanes: &mut [&mut Lane<'_, B, Z>],
    setup: &Setup,
    going: Interrupt<'_>,
) -> Result<[State<f64, B, Z>; WIDTH], SimulationError> {
    let last = lanes.len() - 1;
    let at_rest: [State<f64, B, Z>; WIDTH] = std::array::from_fn(|i| match lanes[i.min(last)].player.rest {
        Ok(rest) => rest.state.clone(),
        Err(_) => State::at_rest([0.0; B]),
    });
    // Lanes are grouped so that all begin at rest or none does.
    if lanes[0].player.stroke.begins_at_m(setup.start_s) <= 0.0 {
        return Ok(at_rest);
    }
    let mut inputs = [Input::Free; WIDTH];
    for (i, lane) in lanes.iter().enumerate() {
        let position = lane.rest.site_m + lane.player.stroke.begins_at_m(setup.start_s);
        inputs[i..].fill(Input::Motion { position, velocity: 0.0 });
    }
    let models = std::array::from_fn(|i| lanes[i.min(last)].model.clone());
    let settled = come_to_rest::<B, Z, N>(models, at_rest.clone(), &inputs, going)?;
    let mut states = at_rest;
    for (i, (state, settled)) in states.iter_mut().zip(settled).enumerate() {
        let lane = &mut lanes[i.min(last)];
        let begins_at_m = lane.player.stroke.begins_at_m(setup.start_s);
        match settled.map_or_else(|| alone(lane.player.instrument, setup.settings, begins_at_m), Ok) {
            Ok(settled) => *state = settled,
            Err(error) => lane.failed = Some(error.into()),
        }
    }
    Ok(states)
}
