//! A mechanism of a fixed size with what looks on: the code that every step outside the lanes goes through.

use core::cell::{Cell, OnceCell};

use moreau::{
    Accuracy, Contact, ControlledStep, Controller, Energies, GROUND, Halves, Input, Ledger, Model, ModelError, Outcome,
    Pose, Settings, Sleep, State, StepReport, TrackedPoint, Workspace, controlled_step, step_apart,
};

use crate::flight::Flight;
use crate::mechanism::View;
use crate::placed::Sight;
use crate::surfaces::Under;
use crate::{InputDuring, Marks, Meeting, OwnedDescription};

/// What a step presses on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Over {
    /// Nothing that yields.
    Nothing,
    /// Surfaces that are still, and the mechanism sleeps.
    Still,
    /// Surfaces that ring while it sleeps.
    Ringing,
    /// Surfaces, and it moves.
    Awake,
}

/// A mechanism without its working memory, which several may share.
pub(crate) struct Stepped<const B: usize, const Z: usize> {
    pub model: Model<f64, B, Z>,
    pub state: State<f64, B, Z>,
    pub sleep: Sleep<f64>,
    pub flight: Flight<B>,
    /// What its zones press on, where that yields.
    pub under: Option<Under>,
    /// The driven point and the drive's direction, which is zero where nothing is driven.
    pub site: (TrackedPoint<f64, B>, [f64; 2]),
    pub bodies: usize,
    /// Absolute angular velocities before the last step, rad/s.
    pub velocity_before: [f64; B],
    /// Whether steps that change nothing may be left out.
    pub may_rest: bool,
    /// Of the last step.
    pub report: StepReport,
    /// Whether the last step was left out.
    skipped: bool,
    clock: Clock,
}

/// Counts steps, so that the instants of steps of one length are rounded once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    pub origin_s: f64,
    pub steps: u64,
    pub now_s: f64,
    pub before_s: f64,
}

impl Clock {
    pub fn at(now_s: f64) -> Self {
        Clock { origin_s: now_s, steps: 0, now_s, before_s: now_s }
    }

    #[inline(always)]
    pub fn tick(&mut self, step_s: f64) {
        self.steps += 1;
        self.before_s = self.now_s;
        self.now_s = self.origin_s + self.steps as f64 * step_s;
    }

    /// The last tick did not happen.
    #[cold]
    fn take_back(&mut self) {
        (self.steps, self.now_s) = (self.steps - 1, self.before_s);
    }
}

impl<const B: usize, const Z: usize> Stepped<B, Z> {
    pub fn new(description: &OwnedDescription, marks: &Marks) -> Result<Self, ModelError> {
        let model: Model<f64, B, Z> = description.model()?;
        let state = State::at_rest(description.first_angles());
        let mut flight = Flight::new(&model, marks);
        flight.look(&model, 0.0, &state.angle, &state.velocity);
        let nowhere = (TrackedPoint::of(&model, GROUND, [0.0; 2]), [0.0; 2]);
        let site = model.site().map_or(nowhere, |s| (TrackedPoint::of(&model, s.body, s.point), s.direction));
        Ok(Stepped {
            bodies: description.bodies.len(),
            velocity_before: state.velocity,
            model,
            state,
            sleep: Sleep::awake(),
            flight,
            under: None,
            site,
            may_rest: true,
            report: StepReport { outcome: Outcome::Converged, newton: 0, solver: 0 },
            skipped: false,
            clock: Clock::at(0.0),
        })
    }

    pub fn now_s(&self) -> f64 {
        self.clock.now_s
    }

    pub fn clock(&self) -> Clock {
        self.clock
    }

    pub fn set_clock(&mut self, clock: Clock) {
        self.clock = clock;
    }

    /// The present instant is called `now_s`; what has been seen so far is forgotten.
    pub fn set_now(&mut self, now_s: f64) {
        self.clock = Clock::at(now_s);
        self.look_anew();
    }

    /// The mechanism was put where it is: the flight begins here.
    pub fn look_anew(&mut self) {
        self.sleep.wake();
        self.skipped = false;
        self.flight.forget();
        self.flight.look(&self.model, self.clock.now_s, &self.state.angle, &self.state.velocity);
    }

    /// It was left out of the steps until this instant, as nothing changed.
    pub fn sleep_ended(&mut self, clock: Clock) {
        self.skipped |= clock.steps != self.clock.steps;
        self.clock = clock;
    }

    /// Whether the last step changed nothing, so that its neighbours with the same input need not be taken.
    pub fn rests(&self) -> bool {
        self.sleep.is_asleep() && self.under.as_ref().is_none_or(|under| under.surfaces.rests())
    }

    /// One step. It is left out where it is known to change nothing.
    #[inline(always)]
    pub fn step<const N: usize>(
        &mut self,
        settings: &Settings<f64>,
        input: &Input<f64>,
        workspace: &mut Workspace<f64, B, Z, N>,
    ) -> StepReport {
        // One call of the step, which is then part of its caller.
        let over = if self.under.is_some() { self.tell_of_surfaces(settings, input, workspace) } else { Over::Nothing };
        let report = self.step_alone(settings, input, workspace);
        if over != Over::Nothing && report.outcome != Outcome::NonFinite {
            self.press_on_surfaces(over, settings, workspace);
        }
        report
    }

    /// Before a step over surfaces that yield: what they do is told. A mechanism that sleeps is left out while they ring, if they cannot reach it.
    #[cold]
    #[inline(never)]
    fn tell_of_surfaces<const N: usize>(
        &mut self,
        settings: &Settings<f64>,
        input: &Input<f64>,
        workspace: &mut Workspace<f64, B, Z, N>,
    ) -> Over {
        let Stepped { under: Some(under), sleep, model, state, may_rest, .. } = self else { return Over::Nothing };
        let rested = under.surfaces.rests();
        if !rested && sleep.is_asleep() {
            // Could a surface touch the mechanism where it is now?
            let pose = Pose::of(model, &state.angle);
            let reaches = |(index, &zone): (usize, &usize)| {
                under.surfaces.may_reach(index) && pose.gap(model, zone) > -model.excursion(zone)
            };
            if under.surfaces.zones().iter().enumerate().any(reaches) {
                sleep.wake();
            }
        }
        let asleep = *may_rest && sleep.would_rest(input).is_some();
        if !asleep {
            under.tell(settings, workspace);
        }
        match (asleep, rested) {
            (true, true) => Over::Still,
            (true, false) => Over::Ringing,
            (false, _) => Over::Awake,
        }
    }

    /// After a step: what it pressed with, and the surfaces go on.
    #[cold]
    #[inline(never)]
    fn press_on_surfaces<const N: usize>(
        &mut self,
        over: Over,
        settings: &Settings<f64>,
        workspace: &mut Workspace<f64, B, Z, N>,
    ) {
        let Some(under) = &mut self.under else { return };
        if over == Over::Awake {
            workspace.settle_surfaces(&self.model, settings);
            for (index, &zone) in under.surfaces.zones().iter().enumerate() {
                under.forces[index] = workspace.normal_force(&self.model, settings, zone);
            }
        }
        if over != Over::Still {
            under.advance();
        }
    }

    /// Whether the last step was left out.
    pub fn was_left_out(&self) -> bool {
        self.skipped
    }

    /// Energies of the mechanism as it is, at given velocities, and of what it presses on.
    pub fn energies(&self, state: &State<f64, B, Z>) -> Energies {
        let Some(under) = &self.under else { return Energies::of(&self.model, state) };
        let mechanism = Energies::displaced(&self.model, state, |zone| under.displacement(zone));
        Energies { surface: under.surfaces.energy(), ..mechanism }
    }

    #[inline(always)]
    fn step_alone<const N: usize>(
        &mut self,
        settings: &Settings<f64>,
        input: &Input<f64>,
        workspace: &mut Workspace<f64, B, Z, N>,
    ) -> StepReport {
        let before_s = self.clock.now_s;
        self.clock.tick(settings.step);
        let Stepped { model, state, sleep, .. } = self;
        if self.may_rest
            && let Some(report) = sleep.would_rest(input)
        {
            self.skipped = true;
            return report;
        }
        self.velocity_before = state.velocity;
        let report = if self.may_rest {
            sleep.step(model, settings, input, state, workspace)
        } else {
            step_apart(model, settings, input, state, workspace)
        };
        self.report = report;
        if self.skipped {
            self.skipped = false;
            self.flight.stood(before_s, settings.step);
        }
        if report.outcome != Outcome::NonFinite {
            self.flight.look(&self.model, self.clock.now_s, &self.state.angle, &self.state.velocity);
        }
        report
    }

    /// The meeting in the last step, if there was one.
    #[inline(always)]
    pub fn flight_met(&self) -> Option<Meeting> {
        if self.skipped { None } else { self.flight.met() }
    }

    /// What the flight has shown until an instant, up to which nothing changes any more: the two latest samples.
    pub fn flight_samples(&self, now: &Clock) -> [Option<[f64; 3]>; 2] {
        let mut flight = self.flight.clone();
        if self.skipped || now.steps != self.clock.steps {
            flight.stood(now.now_s, now.now_s - now.before_s);
        }
        flight.samples(&self.model)
    }

    /// Goes on with such samples.
    pub fn resume_flight(&mut self, samples: [Option<[f64; 3]>; 2]) {
        self.skipped = false;
        self.flight.resume(samples);
    }

    /// Where the driven point and the marked one are, and how fast; with the forces of drive and marked zone in the last step, N.
    #[inline(always)]
    pub fn view(&self, drive_n: f64, zone_n: f64) -> View {
        let State { angle, velocity, .. } = &self.state;
        let (site, [dx, dy]) = &self.site;
        let [[x, v], [point_m, point_m_s]] = TrackedPoint::motions([site, self.flight.point()], angle, velocity);
        let [site_m, site_m_s] = [dx * x[0] + dy * x[1], dx * v[0] + dy * v[1]];
        View { site_m, site_m_s, drive_n, point_m, point_m_s, zone_n, met: self.flight_met() }
    }
}

/// A mechanism with its own working memory.
pub(crate) struct Engine<const B: usize, const Z: usize, const N: usize> {
    pub core: Stepped<B, Z>,
    pub marks: Marks,
    pub settings: Settings<f64>,
    pub workspace: Workspace<f64, B, Z, N>,
    /// While steps are controlled.
    pub control: Option<Box<Control<B, Z, N>>>,
    /// The pose now, worked out when it is asked for.
    pose: OnceCell<Pose<f64, B>>,
    /// The zones as they acted in the last step, where somebody wants to know of each step.
    contacts: Option<Box<[Option<Contact<f64>>; Z]>>,
    /// What surfaces that yield had lost when the ledger was opened, J.
    pub lost_before: f64,
    /// What had been given through them when it was last booked, J.
    pub given_before: Cell<f64>,
}

pub(crate) struct Control<const B: usize, const Z: usize, const N: usize> {
    controller: Controller<f64, Z>,
    halves: Halves<f64, B, Z, N>,
    /// The half that was last.
    half: usize,
}

impl<const B: usize, const Z: usize, const N: usize> Engine<B, Z, N> {
    pub fn new(description: &OwnedDescription, marks: &Marks, settings: Settings<f64>) -> Result<Self, ModelError> {
        let core: Stepped<B, Z> = Stepped::new(description, marks)?;
        let workspace = Workspace::for_model(&core.model)?;
        Ok(Engine {
            core,
            marks: *marks,
            settings,
            workspace,
            control: None,
            pose: OnceCell::new(),
            contacts: None,
            lost_before: 0.0,
            given_before: Cell::new(0.0),
        })
    }

    /// What acted in the last step, and how it was taken: of a controlled step its last half, else the step itself.
    pub fn last(&self) -> (&Settings<f64>, &Workspace<f64, B, Z, N>) {
        match self.control.as_deref() {
            Some(control) => (&control.halves.settings, &control.halves.workspace[control.half]),
            None => (&self.settings, &self.workspace),
        }
    }

    pub fn forget_pose(&mut self) {
        // Not `take`, which would move out what is there.
        self.pose = OnceCell::new();
    }

    pub fn sight(&self) -> Sight<'_, B, Z> {
        let pose = self.pose.get_or_init(|| Pose::of(&self.core.model, &self.core.state.angle));
        Sight { model: &self.core.model, pose, velocity: &self.core.state.velocity }
    }

    pub fn pose(&self) -> &Pose<f64, B> {
        self.sight().pose
    }

    /// From now on the zones are looked at after every step.
    pub fn keep_contacts(&mut self) {
        self.contacts.get_or_insert_with(|| Box::new([None; Z]));
        self.look_at_contacts();
    }

    /// The zones as they acted in the last step; none where they are not kept.
    pub fn contacts(&self) -> &[Option<Contact<f64>>] {
        self.contacts.as_deref().map_or(&[], |contacts| contacts)
    }

    fn look_at_contacts(&mut self) {
        let Engine { core, settings, workspace, control, contacts: Some(contacts), .. } = self else { return };
        let (settings, workspace) = match control.as_deref() {
            Some(control) => (&control.halves.settings, &control.halves.workspace[control.half]),
            None => (&*settings, &*workspace),
        };
        contacts.fill(None);
        for &z in workspace.touched_zones() {
            contacts[z] = workspace.contact(&core.model, settings, z);
        }
    }

    /// A step has been taken.
    pub fn look_again(&mut self) {
        self.forget_pose();
        self.look_at_contacts();
    }

    /// What there is to be seen now.
    #[inline(always)]
    pub fn view(&self) -> View {
        let (settings, workspace) = self.last();
        let zone_n = self.marks.zone.map_or(0.0, |zone| workspace.normal_force(&self.core.model, settings, zone));
        self.core.view(workspace.drive_force(), zone_n)
    }

    pub fn step(&mut self, input: &Input<f64>) -> StepReport {
        self.control = None;
        let rested = self.core.rests();
        let report = self.core.step(&self.settings, input, &mut self.workspace);
        if report.outcome == Outcome::NonFinite {
            // It is where it was, and when.
            self.core.clock.take_back();
        }
        if !(rested && self.core.rests()) {
            self.look_again();
        }
        report
    }

    /// Books the last step.
    pub fn book(&self, ledger: &mut Ledger) {
        let (settings, workspace) = self.last();
        let Stepped { model, state, velocity_before, .. } = &self.core;
        if let Some(contacts) = &self.contacts {
            ledger.record_contacts(model, settings, velocity_before, state, workspace, contacts);
        }
        if let Some(under) = &self.core.under {
            ledger.surface = under.surfaces.lost() - self.lost_before;
            let given = under.surfaces.given();
            let work = given - self.given_before.replace(given);
            ledger.drive_work += work;
            ledger.drive_work_in += work.max(0.0);
        }
    }

    pub fn controlled_step(
        &mut self,
        accuracy: &Accuracy<f64>,
        limit: f64,
        ends: &dyn Fn(f64) -> f64,
        input: &mut InputDuring,
        look: &mut dyn FnMut(&Self),
    ) -> ControlledStep<f64> {
        let Engine { core, settings, control, .. } = self;
        core.sleep.wake();
        let control = control.get_or_insert_with(|| {
            let controller = Controller::new(settings.step);
            Box::new(Control { controller, halves: Halves::new(settings), half: 1 })
        });
        let before = core.state.velocity;
        let Stepped { model, state, .. } = core;
        let input = |from: f64, h: f64, state: &State<f64, B, Z>| input(from, h, &|| model.site_position(&state.angle));
        let Control { controller, halves, half } = control.as_mut();
        let report = controlled_step(model, settings, accuracy, controller, limit, input, state, halves);
        if report.outcome == Outcome::NonFinite {
            return report;
        }
        *half = 0;
        let end = std::mem::replace(state, halves.middle.clone());
        self.arrive(before, ends(0.5 * report.step));
        look(self);
        let before = self.core.state.velocity;
        self.core.state = end;
        if let Some(control) = &mut self.control {
            control.half = 1;
        }
        self.arrive(before, ends(report.step));
        look(self);
        report
    }

    /// A half of a controlled step has ended.
    fn arrive(&mut self, velocity_before: [f64; B], now_s: f64) {
        self.look_again();
        let core = &mut self.core;
        core.velocity_before = velocity_before;
        core.set_clock(Clock::at(now_s));
        core.flight.look(&core.model, now_s, &core.state.angle, &core.state.velocity);
    }
}
