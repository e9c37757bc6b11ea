//! Mechanisms stepped in lanes: brought to rest, and played.

use moreau::{Ledger, ModelError, SavedState, Settings, SiteInput, StepOutcome};
use moreau_kernels::{EveryBody, LaneObserver, Lanes, OwnedDescription, SideBySide, Size, lane_observer, side_by_side};

use super::sampling::{Sampled, Sampling};
use super::{JobResult, Played, Stroke};
use erard::Progress;
use erard::assembly::{describe, probes};
use erard::events::EventDetector;
use erard::instrument::Instrument;
use erard::player::equilibrium::{self, PATIENCE_S, Settling};
use erard::player::rest::Rest;
use erard::player::{self, Action, ActionError};
use erard::run::{Setup, SimulationError};
use erard::trust::{self, Extremes};

/// Steps between questions to the caller whether to go on.
const ASK_EVERY: u64 = 1024;
/// Room for a mechanism's angles.
const BODIES: usize = Size::Most.holds()[0];

/// A state of any size of mechanism.
type State = SavedState<f64, 12, 32>;

/// An instrument's description with its undriven equilibrium.
pub(super) struct AtRest {
    description: OwnedDescription,
    pub state: State,
}

/// The equilibrium, or the reason why there is none.
pub(super) type Rested = Result<AtRest, ActionError>;

/// Instrument and stroke of one lane.
pub(super) struct Player<'a> {
    pub instrument: &'a Instrument,
    pub rest: &'a Rested,
    pub stroke: Stroke<'a>,
}

/// State at rest at these angles.
fn standing(angles: &[f64], pivot_friction: &[f64]) -> State {
    let of = |values: &[f64]| std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0));
    State { pivot_friction: of(pivot_friction), ..State::at_rest(of(angles)) }
}

/// Makes a group of the mechanisms of some lanes; spare lanes repeat the last one.
fn group(
    mut descriptions: Vec<&OwnedDescription>,
    mut states: Vec<State>,
    settings: &Settings<f64>,
    lanes: Lanes,
) -> Result<Box<dyn SideBySide>, ModelError> {
    let count = lanes.count().max(descriptions.len());
    if let (Some(&description), Some(&state)) = (descriptions.last(), states.last()) {
        descriptions.resize(count, description);
        states.resize(count, state);
    }
    side_by_side(&descriptions, &states, settings, lanes)
}

/// Sets the inputs of all lanes of a group; spare lanes repeat the last one.
fn inputs_of(own: impl Iterator<Item = SiteInput<f64>>, inputs: &mut [SiteInput<f64>]) {
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
pub(super) fn settle(
    instruments: &[&Instrument],
    settings: Settings<f64>,
    lanes: Lanes,
    progress: &mut Progress<'_>,
) -> Result<Vec<Rested>, SimulationError> {
    let descriptions: Vec<OwnedDescription> = instruments.iter().map(|instrument| describe(instrument)).collect();
    let drawn: Vec<State> = descriptions.iter().map(|description| standing(&description.angles, &[])).collect();
    let free = vec![SiteInput::Free; instruments.len()];
    let states = match rests_of(&descriptions.iter().collect::<Vec<_>>(), &drawn, &free, lanes, progress) {
        Ok(states) => states,
        Err(SimulationError::Interrupted) => return Err(SimulationError::Interrupted),
        // If one cannot be assembled, each is settled alone and reports its own error.
        Err(_) => vec![None; instruments.len()],
    };
    let each = instruments.iter().zip(descriptions).zip(states);
    let rested = each.map(|((instrument, description), state)| {
        let state = state.map_or_else(|| alone(instrument, settings, 0.0), Ok)?;
        Ok(AtRest { description, state })
    });
    Ok(rested.collect())
}

/// Finds the equilibria of mechanisms; `None` for one that [`equilibrium::settle`] would have to slow down, that flies
/// apart, or whose steps find no solution. Lanes wait for each other's iterations: the others start again without a
/// hopeless one, with the same results as if it had never been there.
fn rests_of(
    descriptions: &[&OwnedDescription],
    from: &[State],
    inputs: &[SiteInput<f64>],
    lanes: Lanes,
    progress: &mut Progress<'_>,
) -> Result<Vec<Option<State>>, SimulationError> {
    let mut states: Vec<Option<State>> = vec![None; descriptions.len()];
    let mut together: Vec<usize> = (0..descriptions.len()).collect();
    while !together.is_empty() {
        let begin = together.iter().map(|&i| from[i]).collect();
        let driven: Vec<SiteInput<f64>> = together.iter().map(|&i| inputs[i]).collect();
        match come_to_rest(together.iter().map(|&i| descriptions[i]).collect(), begin, &driven, lanes, progress)? {
            Together::Ended(rested) => {
                together.iter().zip(rested).for_each(|(&i, state)| states[i] = state);
                break;
            }
            Together::Hopeless(lane) => drop(together.remove(lane)),
        }
    }
    Ok(states)
}

/// Result of a search for several equilibria.
enum Together {
    /// The state of each, or `None` for one that [`equilibrium::settle`] would have to slow down.
    Ended(Vec<Option<State>>),
    /// The lane of one that flies apart or whose steps find no solution.
    Hopeless(usize),
}

/// Steps mechanisms until they rest, as [`equilibrium::settle`] does.
fn come_to_rest(
    descriptions: Vec<&OwnedDescription>,
    from: Vec<State>,
    own_inputs: &[SiteInput<f64>],
    lanes: Lanes,
    progress: &mut Progress<'_>,
) -> Result<Together, SimulationError> {
    let count = descriptions.len();
    let bodies = descriptions.first().map_or(0, |d| d.bodies.len()).min(BODIES);
    let mut group = group(descriptions, from, &equilibrium::settings(), lanes)?;
    let mut inputs = vec![SiteInput::Free; lanes.count().max(count)];
    inputs_of(own_inputs.iter().copied(), &mut inputs);
    let mut outcomes = vec![StepOutcome::Converged; inputs.len()];
    let mut rested: Vec<Option<State>> = vec![None; count];
    let (mut angles, mut velocities) = ([0.0; BODIES], [0.0; BODIES]);
    let (mut settling, mut waited_for) = (vec![Settling::default(); count], vec![true; count]);
    let mut steps = 0_u64;
    while waited_for.contains(&true) {
        if steps.is_multiple_of(ASK_EVERY) && !progress(0.0) {
            return Err(SimulationError::Interrupted);
        }
        steps += 1;
        group.step(&inputs, &mut outcomes);
        for i in 0..count {
            if !waited_for[i] {
                continue;
            }
            group.motion(i, &mut angles, &mut velocities);
            let rests = settling[i].rests(&velocities[..bodies]);
            if settling[i].is_hopeless(outcomes[i]) {
                return Ok(Together::Hopeless(i));
            }
            if rests {
                let mut state = group.state(i);
                state.velocity = [0.0; BODIES];
                rested[i] = Some(state);
                waited_for[i] = false;
            } else if settling[i].time_s > PATIENCE_S {
                waited_for[i] = false;
            }
        }
    }
    Ok(Together::Ended(rested))
}

/// Brings one instrument to rest alone, first undriven and then, if it begins there, under a finger at this depth.
fn alone(instrument: &Instrument, settings: Settings<f64>, begins_at_m: f64) -> Result<State, ActionError> {
    let mut action = Action::with(instrument, settings)?;
    if begins_at_m > 0.0 {
        let finger = player::Input::Motion { position_m: begins_at_m, velocity_m_per_s: 0.0 };
        action.settle(instrument, finger, &mut |_| true)?;
    }
    // The felts' internal state belongs to the pose.
    let memory = action.mechanism().save().state.memory;
    Ok(State { memory, ..standing(action.angles(), action.mechanism().readout().pivot_friction) })
}

/// One lane during play.
struct Lane<'a> {
    player: &'a Player<'a>,
    drive: Box<player::Drive<'a>>,
    at_rest: &'a AtRest,
    observer: Box<dyn LaneObserver>,
    rest: Rest,
    detector: EventDetector,
    highest_m: f64,
    unconverged_steps: u64,
    steps: u64,
    ledger: Option<Ledger>,
    extremes: Extremes,
    sampled: Option<Sampled<'a>>,
    failed: Option<SimulationError>,
}

impl<'a> Lane<'a> {
    fn new(player: &'a Player<'a>, setup: &Setup, sampling: Option<&'a Sampling>) -> Result<Self, SimulationError> {
        let at_rest = player.rest.as_ref().map_err(Clone::clone)?;
        let drive = setup.driven(player.stroke.as_ref())?;
        if player.instrument.roles.key.is_none() && drive(setup.start_s) != player::Input::Free {
            return Err(SimulationError::NoKey);
        }
        let mut observer = lane_observer(&at_rest.description, &probes(player.instrument))?;
        observer.update(setup.start_s, &at_rest.state.angle, &at_rest.state.velocity);
        let rest = Rest::of(player.instrument, observer.as_ref());
        Ok(Lane {
            player,
            drive: Box::new(drive),
            at_rest,
            observer: lane_observer(&at_rest.description, &probes(player.instrument))?,
            rest,
            detector: EventDetector::new(player.instrument),
            highest_m: 0.0,
            unconverged_steps: 0,
            steps: 0,
            ledger: None,
            extremes: Extremes::new(player.instrument),
            sampled: sampling.map(|sampling| Sampled::new(sampling, player.instrument)),
            failed: None,
        })
    }

    /// Observes the present mechanism, as in a run.
    fn observe(&mut self, time_s: f64, angles: &EveryBody, velocities: &EveryBody) {
        self.observer.update(time_s, angles, velocities);
        let Rest { site_m, head_m } = Rest::of(self.player.instrument, self.observer.as_ref());
        let (key_m, hammer_rise_m) = (site_m - self.rest.site_m, head_m - self.rest.head_m);
        self.extremes.note_travels(time_s, key_m, hammer_rise_m);
        if self.observer.is_far() && self.detector.awaits_impacts_only() {
            return;
        }
        self.detector.observe(time_s, key_m, hammer_rise_m, self.observer.impact(), self.observer.as_ref());
        if let (Some(impact), Some(ledger)) = (self.observer.impact(), &self.ledger) {
            let now = self.observer.energies();
            self.extremes.note_blow(&impact, Ledger { now, ..ledger.clone() }.given());
        }
        self.highest_m = self.highest_m.max(hammer_rise_m);
    }

    /// Takes a row of samples at the last observed pose.
    fn sample(&mut self, time_s: f64, angles: &EveryBody, velocities: &EveryBody) {
        let Some(sampled) = &mut self.sampled else { return };
        let now = Rest::of(self.player.instrument, self.observer.as_ref());
        let force_n = match (self.player.stroke)(time_s) {
            player::Input::Force(force_n) => force_n,
            _ => 0.0,
        };
        let roles = &self.player.instrument.roles;
        let head_m_per_s = match roles.hammer.filter(|_| sampled.has_speed()) {
            Some(hammer) => {
                let up = self.observer.velocity_row(hammer, roles.hammer_strike_point_m, [0.0, 1.0]);
                up.iter().zip(velocities).map(|(row, velocity)| row * velocity).sum()
            }
            None => 0.0,
        };
        let travels = [force_n, now.site_m - self.rest.site_m, now.head_m - self.rest.head_m, head_m_per_s];
        sampled.push(travels, angles, velocities);
    }

    /// The input of the step from t0; a failed mechanism gets a harmless one of the same kind.
    fn input(&self, t0: f64, settings: &Settings<f64>) -> SiteInput<f64> {
        let Settings { step: h, theta, .. } = *settings;
        let input = self.rest.input(&self.drive, t0, h, theta, h, &|| self.observer.site_position());
        if self.failed.is_none() {
            return input;
        }
        match input {
            SiteInput::Free => SiteInput::Free,
            SiteInput::Force(_) => SiteInput::Force(0.0),
            SiteInput::Motion { .. } => SiteInput::Motion { position: self.rest.site_m, velocity: 0.0 },
            SiteInput::Rigid { .. } => SiteInput::Rigid { velocity: 0.0 },
            SiteInput::Hand(hand) => {
                SiteInput::Hand(moreau::SiteHand { position: self.rest.site_m, velocity: 0.0, force: 0.0, ..hand })
            }
        }
    }

    /// Begins at the mechanism's state in its group, with the energy balance opened if it is kept.
    fn begin(&mut self, group: &dyn SideBySide, index: usize, keeps_ledger: bool) {
        self.observer.begin(group, index);
        self.ledger = keeps_ledger.then(|| Ledger::open_at(self.observer.energies(), 0.0, 0.0));
    }

    /// Computes the step's forces and adds its energy to the balance. Call it before observing the end of the step.
    /// Returns whether the step changed any observed value.
    fn retrace(
        &mut self,
        input: &SiteInput<f64>,
        settings: &Settings<f64>,
        group: &dyn SideBySide,
        index: usize,
    ) -> bool {
        // Without a ledger, neither forces nor states are needed once the string is struck.
        if self.ledger.is_none() && !self.detector.awaits_let_off() {
            return false;
        }
        // A step without change adds no energy.
        if !self.observer.retrace(settings, input, group, index) {
            return false;
        }
        if let Some(ledger) = &mut self.ledger {
            self.observer.record_energy(ledger, settings, input);
        }
        true
    }

    /// Records extreme angles of bodies and compressions of felts.
    fn note_extremes(&mut self, time_s: f64, angles: &[f64], changed: bool) {
        self.extremes.note_angles(time_s, angles);
        if self.ledger.is_none() || !changed {
            return;
        }
        let zones = 0..self.player.instrument.zones.len();
        self.extremes.note_compressions(time_s, zones.map(|zone| self.observer.compression(zone)));
    }

    fn finish(self) -> JobResult {
        if let Some(error) = self.failed {
            return Err(error);
        }
        let energy_residual = self.ledger.map(|mut ledger| {
            ledger.now = self.observer.energies();
            trust::energy_residual(&ledger)
        });
        let mut warnings: Vec<_> = energy_residual.and_then(trust::of_energy).into_iter().collect();
        warnings.extend(trust::of_steps(self.unconverged_steps, self.steps));
        warnings.extend(trust::of_extremes(self.player.instrument, &self.extremes));
        let events = self.detector.finish();
        warnings.extend(trust::of_impacts(&events));
        Ok(Played {
            events,
            highest_m: self.highest_m,
            unconverged_steps: self.unconverged_steps,
            energy_residual,
            warnings,
            samples: self.sampled.map(Sampled::into_columns).unwrap_or_default(),
        })
    }
}

/// Plays strokes in lanes, all of one kind on one topology, at most as many as there are lanes.
///
/// # Errors
/// [`SimulationError::Interrupted`].
pub(super) fn play(
    players: &[Player<'_>],
    setup: &Setup,
    sampling: Option<&Sampling>,
    lanes: Lanes,
    progress: &mut Progress<'_>,
) -> Result<Vec<JobResult>, SimulationError> {
    let mut begun: Vec<Result<Lane, SimulationError>> =
        players.iter().map(|player| Lane::new(player, setup, sampling)).collect();
    let mut own: Vec<&mut Lane> = begun.iter_mut().flatten().collect();
    if !own.is_empty() {
        step_all(&mut own, setup, lanes, progress)?;
    }
    Ok(begun.into_iter().map(|lane| lane.and_then(Lane::finish)).collect())
}

/// Steps mechanisms in lanes to the end of their strokes.
fn step_all(
    own: &mut [&mut Lane<'_>],
    setup: &Setup,
    lanes: Lanes,
    progress: &mut Progress<'_>,
) -> Result<(), SimulationError> {
    let states = first_states(own, setup, lanes, progress)?;
    let descriptions = own.iter().map(|lane| &lane.at_rest.description).collect();
    let mut group = group(descriptions, states, &setup.settings, lanes)?;
    let (mut angles, mut velocities) = ([0.0; BODIES], [0.0; BODIES]);
    let mut inputs = vec![SiteInput::Free; lanes.count().max(own.len())];
    let mut outcomes = vec![StepOutcome::Converged; inputs.len()];
    let steps = setup.check()?;
    let h = setup.settings.step;
    for (i, lane) in own.iter_mut().enumerate() {
        group.motion(i, &mut angles, &mut velocities);
        lane.begin(group.as_ref(), i, setup.ledger);
        lane.observe(setup.start_s, &angles, &velocities);
        lane.sample(setup.start_s, &angles, &velocities);
    }
    for n in 0..steps {
        if n.is_multiple_of(ASK_EVERY) {
            if !progress(0.0) {
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
                StepOutcome::Converged => {}
                StepOutcome::IterationLimit => lane.unconverged_steps += 1,
                StepOutcome::NonFinite | StepOutcome::TooManyLaws => {
                    lane.failed = Some(SimulationError::NonFinite { time_s: t0 });
                    continue;
                }
            }
            group.motion(i, &mut angles, &mut velocities);
            let now_s = setup.start_s + (n + 1) as f64 * h;
            let changed = lane.retrace(&inputs[i], &setup.settings, group.as_ref(), i);
            lane.observe(now_s, &angles, &velocities);
            if lane.sampled.as_ref().is_some_and(|sampled| sampled.is_row(n + 1)) {
                lane.sample(now_s, &angles, &velocities);
            }
            lane.steps = n + 1;
            lane.note_extremes(now_s, &angles, changed);
        }
    }
    Ok(())
}

/// Initial states of the lanes: at rest, or under a finger that is already down.
fn first_states(
    own: &mut [&mut Lane<'_>],
    setup: &Setup,
    lanes: Lanes,
    progress: &mut Progress<'_>,
) -> Result<Vec<State>, SimulationError> {
    let mut at_rest: Vec<State> = own.iter().map(|lane| lane.at_rest.state).collect();
    if let Some(hand) = setup.hand {
        for (state, lane) in at_rest.iter_mut().zip(own.iter()) {
            state.hand = [lane.rest.site_m + hand.start_m, hand.start_m_per_s];
        }
        return Ok(at_rest);
    }
    let begins_at_m: Vec<f64> =
        own.iter().map(|lane| (lane.player.stroke)(setup.start_s).position_m().max(0.0)).collect();
    // The groups are formed so that all lanes begin at rest or none does.
    if begins_at_m.iter().all(|at| *at <= 0.0) {
        return Ok(at_rest);
    }
    let finger = |(lane, at): (&&mut Lane, &f64)| SiteInput::Motion { position: lane.rest.site_m + at, velocity: 0.0 };
    let inputs: Vec<SiteInput<f64>> = own.iter().zip(&begins_at_m).map(finger).collect();
    let descriptions: Vec<&OwnedDescription> = own.iter().map(|lane| &lane.at_rest.description).collect();
    let settled = rests_of(&descriptions, &at_rest, &inputs, lanes.in_doubles(), progress)?;
    let mut states = at_rest;
    for (((state, settled), lane), at) in states.iter_mut().zip(settled).zip(own).zip(begins_at_m) {
        match settled.map_or_else(|| alone(lane.player.instrument, setup.settings, at), Ok) {
            Ok(settled) => *state = settled,
            Err(error) => lane.failed = Some(error.into()),
        }
    }
    Ok(states)
}
