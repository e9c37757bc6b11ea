//! Engine of one size: a mechanism that takes steps, and its outputs. Every step outside the lanes goes through
//! [`Stepped::step`].

use core::cell::OnceCell;

use moreau::{
    Accuracy, Contact, ControlledStep, Energies, GROUND, ImpactPredictor, Ledger, LossIn, Model, ModelError, Pose,
    SavedState, Settings, SiteHand, SiteInput, Sleep, State, StepOutcome, StepReport, TrackedPoint, Workspace,
    step_or_stay, step_out_of_line,
};

use crate::controlled::InputDuring;
use crate::controlled::{Control, hand_of};
use crate::impact::predictor;
use crate::mechanism::{Mechanism, Readout, Saved, StatePart, StepOutput, Stepping};
use crate::observation::{Observation, site_position};
use crate::surfaces::{Halving, Over, Surfaces, Under};
use crate::{Impact, OwnedDescription, Probes};

/// Mechanism without its working memory, which several mechanisms may share.
pub(crate) struct Stepped<const B: usize, const Z: usize> {
    pub model: Model<f64, B, Z>,
    pub state: State<f64, B, Z>,
    pub sleep: Sleep<f64>,
    pub predictor: ImpactPredictor<f64, B>,
    /// Compliant external subsystem under its zones; `None` if there is none.
    pub under: Option<Under>,
    /// Driven point and direction of the drive; the direction is zero without a drive.
    pub site: (TrackedPoint<f64, B>, [f64; 2]),
    pub bodies: usize,
    /// Absolute angular velocities before the last step, rad/s.
    pub velocity_before: [f64; B],
    /// Hand that drove the last step, with its position, m, and velocity, m/s, before it.
    pub hand: Option<(SiteHand<f64>, [f64; 2])>,
    /// Whether steps that change nothing may be skipped.
    pub may_rest: bool,
    /// Report of the last step.
    pub report: StepReport,
    /// Whether the last step was skipped.
    skipped: bool,
    clock: Clock,
}

/// Counter of steps. It rounds the instants of fixed steps only once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    pub origin_s: f64,
    pub steps: u64,
    pub now_s: f64,
    pub before_s: f64,
}

impl Clock {
    pub(crate) fn at(now_s: f64) -> Self {
        Clock { origin_s: now_s, steps: 0, now_s, before_s: now_s }
    }

    #[inline(always)]
    pub(crate) fn tick(&mut self, step_s: f64) {
        self.steps += 1;
        self.before_s = self.now_s;
        self.now_s = self.origin_s + self.steps as f64 * step_s;
    }

    /// Advances the clock by one part of a step.
    #[inline(always)]
    fn pass(&mut self, step_s: f64, part: Share) {
        if part.is_last() {
            self.tick(step_s);
        } else {
            self.before_s = self.now_s;
            self.now_s = self.origin_s + (self.steps as f64 + part.ends()) * step_s;
        }
    }

    /// Takes back the last part of a step. The grid of steps restarts at the part's beginning if this is not on the
    /// grid.
    #[cold]
    fn take_back(&mut self, part: Share) {
        if part.at > 0 {
            *self = Clock::at(self.before_s);
            return;
        }
        self.now_s = self.before_s;
        self.steps -= u64::from(part.is_last());
    }
}

/// One of the equal parts of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Share {
    /// Index of this part, from 0.
    pub at: u32,
    /// Number of parts.
    pub of: u32,
}

impl Share {
    /// A step in one part.
    pub(crate) const WHOLE: Self = Share { at: 0, of: 1 };

    /// Returns all parts of a step.
    pub(crate) fn all(of: u32) -> impl Iterator<Item = Self> {
        (0..of).map(move |at| Share { at, of })
    }

    fn is_last(self) -> bool {
        self.at + 1 == self.of
    }

    /// Returns the share of the step that is over when this part begins.
    pub(crate) fn begins(self) -> f64 {
        f64::from(self.at) / f64::from(self.of)
    }

    /// Returns the share of the step that is over when this part ends.
    fn ends(self) -> f64 {
        f64::from(self.at + 1) / f64::from(self.of)
    }

    /// Returns the settings of this part, from those of the step.
    #[inline(always)]
    pub(crate) fn settings(self, whole: &Settings<f64>) -> Settings<f64> {
        if self.of == 1 { *whole } else { Settings { step: whole.step / f64::from(self.of), ..*whole } }
    }

    /// Returns the input of this part, from that of the step: a force stays constant, a position advances at its
    /// velocity.
    #[inline(always)]
    pub(crate) fn input(self, whole: &Settings<f64>, input: &SiteInput<f64>) -> SiteInput<f64> {
        if self.of == 1 {
            return *input;
        }
        // From the theta point of the step to that of the part.
        let later_s = whole.step * (self.begins() + whole.theta * (self.ends() - self.begins() - 1.0));
        match *input {
            SiteInput::Motion { position, velocity } => {
                SiteInput::Motion { position: position + later_s * velocity, velocity }
            }
            SiteInput::Hand(hand) => {
                SiteInput::Hand(SiteHand { position: hand.position + later_s * hand.velocity, ..hand })
            }
            other => other,
        }
    }
}

/// Returns the common report of several parts of a step: the worst outcome, and the sum of the work.
pub(crate) fn together(a: StepReport, b: StepReport) -> StepReport {
    let rank = |outcome: StepOutcome| match outcome {
        StepOutcome::Converged => 0,
        StepOutcome::IterationLimit => 1,
        StepOutcome::TooManyLaws => 2,
        StepOutcome::NonFinite => 3,
    };
    StepReport {
        outcome: if rank(b.outcome) > rank(a.outcome) { b.outcome } else { a.outcome },
        newton: a.newton.saturating_add(b.newton),
        solver: a.solver.saturating_add(b.solver),
    }
}

pub(crate) const NO_STEP: StepReport = StepReport { outcome: StepOutcome::Converged, newton: 0, solver: 0 };

impl<const B: usize, const Z: usize> Stepped<B, Z> {
    pub(crate) fn new(description: &OwnedDescription, probes: &Probes) -> Result<Self, ModelError> {
        let model: Model<f64, B, Z> = description.model()?;
        let state = State::at_rest(description.first_angles());
        let mut predictor = predictor(&model, probes);
        predictor.update(&model, 0.0, &state.angle, &state.velocity);
        let nowhere = (TrackedPoint::of(&model, GROUND, [0.0; 2]), [0.0; 2]);
        let site = model.site().map_or(nowhere, |s| (TrackedPoint::of(&model, s.body, s.point), s.direction));
        Ok(Stepped {
            bodies: description.bodies.len(),
            velocity_before: state.velocity,
            hand: None,
            model,
            state,
            sleep: Sleep::awake(),
            predictor,
            under: None,
            site,
            may_rest: true,
            report: NO_STEP,
            skipped: false,
            clock: Clock::at(0.0),
        })
    }

    pub(crate) fn set_clock(&mut self, clock: Clock) {
        self.clock = clock;
    }

    /// Starts the prediction of impacts at an instant, s, after the mechanism was moved to another state.
    pub(crate) fn begin_at(&mut self, now_s: f64) {
        self.clock = Clock::at(now_s);
        self.sleep.wake();
        self.skipped = false;
        self.predictor.forget();
        self.predictor.update(&self.model, now_s, &self.state.angle, &self.state.velocity);
    }

    /// Sets the clock after a sleep, in which nothing changed.
    pub(crate) fn sleep_ended(&mut self, clock: Clock) {
        self.skipped |= clock.steps != self.clock.steps;
        self.clock = clock;
    }

    /// Returns whether the last step changed nothing, so that following steps with the same input need not be taken.
    pub(crate) fn rests(&self) -> bool {
        self.sleep.is_asleep() && self.under.as_ref().is_none_or(|under| under.surfaces.rests())
    }

    /// Returns whether the last step was skipped.
    pub(crate) fn was_left_out(&self) -> bool {
        self.skipped
    }

    /// Returns the number of parts of the next step under an input.
    #[inline(always)]
    pub(crate) fn choose(&mut self, input: &SiteInput<f64>) -> u32 {
        match &mut self.under {
            None => 1,
            Some(under) => under.choose(input, (&self.model, &self.state, &mut self.sleep)),
        }
    }

    /// Takes a step, or a part of one, of this length, s, with its settings and input. Skips it if it is known to
    /// change nothing ([`Sleep`]).
    #[inline(always)]
    pub(crate) fn step<const N: usize>(
        &mut self,
        settings: &Settings<f64>,
        input: &SiteInput<f64>,
        (step_s, part): (f64, Share),
        workspace: &mut Workspace<f64, B, Z, N>,
    ) -> StepReport {
        let over = match &self.under {
            None => Over::Nothing,
            Some(under) => {
                let sleep = self.may_rest.then_some(&mut self.sleep);
                under.before_step(settings, input, (&self.model, &self.state, sleep), workspace)
            }
        };
        let before_s = self.clock.now_s;
        self.clock.pass(step_s, part);
        let known = if self.may_rest { self.sleep.would_rest(input) } else { None };
        self.skipped |= known.is_some();
        let report = if let Some(report) = known {
            report
        } else {
            self.velocity_before = self.state.velocity;
            self.hand = hand_of(input, &self.state);
            // A mechanism that moves is not copied: it does not fall asleep in this step.
            let stands = self.state.stands();
            let stays = stands || self.state.stays(settings.step);
            // Rounding makes only a speed alternate that is there. What lies under the mechanism must be still, for the
            // steps ahead to be those that would follow.
            let may_go_round = stays && !stands && self.under.as_ref().is_none_or(|under| under.surfaces.rests());
            let before = (may_go_round || (self.may_rest && stays)).then(|| self.state.clone());
            let report = match &before {
                Some(before) if may_go_round => {
                    step_or_stay(&self.model, settings, input, (before, &mut self.state), workspace)
                }
                _ => step_out_of_line(&self.model, settings, input, &mut self.state, workspace),
            };
            if self.may_rest {
                self.sleep.compare(before.as_ref(), &self.state, input, report);
            }
            self.report = report;
            self.predict_impact(before_s, settings.step);
            report
        };
        if over != Over::Nothing
            && report.outcome != StepOutcome::NonFinite
            && let Some(under) = &mut self.under
        {
            under.after_step(over, settings, &self.model, workspace);
        }
        report
    }

    /// Updates the prediction of an impact after a step that was taken.
    #[inline(always)]
    fn predict_impact(&mut self, before_s: f64, step_s: f64) {
        if self.skipped {
            self.skipped = false;
            self.predictor.unchanged(before_s, step_s);
        }
        if self.report.outcome != StepOutcome::NonFinite {
            self.predictor.update(&self.model, self.clock.now_s, &self.state.angle, &self.state.velocity);
        }
    }

    /// The impact in the last step, if there was one.
    #[inline(always)]
    pub(crate) fn impact(&self) -> Option<Impact> {
        if self.skipped { None } else { self.predictor.impact().map(Impact::from) }
    }

    /// Returns the energies of the mechanism and its surfaces, J, in a state.
    pub(crate) fn energies(&self, state: &State<f64, B, Z>) -> Energies {
        let Some(under) = &self.under else { return Energies::of(&self.model, state) };
        let mechanism = Energies::displaced(&self.model, state, |zone| under.displacement(zone));
        Energies { surface: under.surfaces.energy(), ..mechanism }
    }

    /// Returns the present output, given the forces of drive and probe zone in the last step, N.
    #[inline(always)]
    pub(crate) fn output(&self, drive_n: f64, zone_n: f64, report: StepReport) -> StepOutput {
        let SavedState { angle, velocity, hand, .. } = &*self.state;
        let (site, [dx, dy]) = &self.site;
        let [[x, v], [point_m, point_m_per_s]] = TrackedPoint::motions([site, self.predictor.point()], angle, velocity);
        let [site_m, site_m_per_s] = [dx * x[0] + dy * x[1], dx * v[0] + dy * v[1]];
        let (hand, impact) = (*hand, self.impact());
        StepOutput { site_m, site_m_per_s, drive_n, hand, point_m, point_m_per_s, zone_n, impact, report }
    }

    /// Returns everything that the steps from the present instant on depend on.
    pub(crate) fn save(&self) -> Saved {
        self.save_at(&self.clock)
    }

    /// Returns everything that the steps from a later instant on depend on, if nothing has changed since the last step.
    pub(crate) fn save_at(&self, clock: &Clock) -> Saved {
        let mut predictor = self.predictor.clone();
        if self.skipped || clock.steps != self.clock.steps {
            predictor.unchanged(clock.now_s, clock.now_s - clock.before_s);
        }
        Saved {
            state: self.state.save().sized(),
            origin_s: clock.origin_s,
            steps: clock.steps,
            now_s: clock.now_s,
            flight: predictor.samples(&self.model),
        }
    }

    pub(crate) fn restore(&mut self, saved: &Saved) {
        let Saved { origin_s, steps, now_s, .. } = *saved;
        self.state = State::from(saved.state.sized());
        self.sleep.wake();
        if let Some(under) = &mut self.under {
            under.moved();
        }
        self.set_clock(Clock { origin_s, steps, now_s, before_s: now_s });
        self.skipped = false;
        self.predictor.resume(saved.flight);
        self.report = NO_STEP;
    }
}

/// Mechanism with its own working memory.
pub(crate) struct Engine<const B: usize, const Z: usize, const N: usize> {
    core: Stepped<B, Z>,
    probes: Probes,
    stepping: Stepping,
    /// Settings of the last step, or of its last part.
    taken: Settings<f64>,
    workspace: Workspace<f64, B, Z, N>,
    /// Data of adaptive steps, while these are taken.
    control: Option<Box<Control<B, Z, N>>>,
    /// Present pose, computed when it is needed.
    pose: OnceCell<Pose<f64, B>>,
    /// Contacts of the zones in the last step, if they are kept.
    contacts: Option<Box<[Option<Contact<f64>>; Z]>>,
    /// Output of the last step, at the present state of the mechanism.
    output: StepOutput,
}

impl<const B: usize, const Z: usize, const N: usize> Engine<B, Z, N> {
    pub(crate) fn new(
        description: &OwnedDescription,
        probes: &Probes,
        settings: Settings<f64>,
        surfaces: Option<Box<dyn Surfaces>>,
    ) -> Result<Self, ModelError> {
        let mut core: Stepped<B, Z> = Stepped::new(description, probes)?;
        let workspace = Workspace::for_model(&core.model)?;
        core.under = surfaces.map(|surfaces| Under::new(surfaces, settings.step, Halving::Auto));
        Ok(Engine {
            output: core.output(0.0, 0.0, NO_STEP),
            core,
            probes: *probes,
            stepping: Stepping { settings, halving: Halving::Auto, may_rest: true, keeps_contacts: false },
            taken: settings,
            workspace,
            control: None,
            pose: OnceCell::new(),
            contacts: None,
        })
    }

    /// Returns settings and workspace of the last step; of an adaptive step, those of its second half.
    fn last(&self) -> (&Settings<f64>, &Workspace<f64, B, Z, N>) {
        match self.control.as_deref() {
            Some(control) => control.last(),
            None => (&self.taken, &self.workspace),
        }
    }

    fn pose(&self) -> &Pose<f64, B> {
        self.pose.get_or_init(|| Pose::of(&self.core.model, &self.core.state.angle))
    }

    fn forget_pose(&mut self) {
        // Not `take`, which would move out what is there.
        self.pose = OnceCell::new();
    }

    fn update_contacts(&mut self) {
        let Engine { core, taken, workspace, control, contacts: Some(contacts), .. } = self else { return };
        let (settings, workspace) = match control.as_deref() {
            Some(control) => control.last(),
            None => (&*taken, &*workspace),
        };
        contacts.fill(None);
        for &z in workspace.touched_zones() {
            contacts[z] = workspace.contact(&core.model, settings, z);
        }
    }

    #[inline(always)]
    fn update_output(&mut self, report: StepReport) {
        let (settings, workspace) = self.last();
        let zone_n = self.probes.zone.map_or(0.0, |zone| workspace.normal_force(&self.core.model, settings, zone));
        self.output = self.core.output(workspace.drive_force(), zone_n, report);
    }

    /// Takes a step, or a part of one.
    #[inline(always)]
    fn take(&mut self, input: &SiteInput<f64>, part: Share) {
        let rested = self.core.rests();
        let whole = &self.stepping.settings;
        let own = part.settings(whole);
        let report = self.core.step(&own, input, (whole.step, part), &mut self.workspace);
        if !self.core.was_left_out() {
            // Else the workspace is still that of the step before.
            self.taken = own;
        }
        if report.outcome == StepOutcome::NonFinite {
            // It is where it was, and when.
            self.core.clock.take_back(part);
        }
        if !(rested && self.core.rests()) {
            self.forget_pose();
            self.update_contacts();
        }
        self.update_output(report);
    }

    /// Ends one half of an adaptive step.
    fn arrive(&mut self, velocity_before: [f64; B], now_s: f64) {
        self.forget_pose();
        self.update_contacts();
        let core = &mut self.core;
        core.velocity_before = velocity_before;
        core.set_clock(Clock::at(now_s));
        core.predictor.update(&core.model, now_s, &core.state.angle, &core.state.velocity);
        let report = self.core.report;
        self.update_output(report);
    }
}

impl<const B: usize, const Z: usize, const N: usize> Mechanism for Engine<B, Z, N> {
    fn step(&mut self, input: &SiteInput<f64>) -> &StepOutput {
        self.control = None;
        let of = self.core.choose(input);
        if of == 1 {
            self.take(input, Share::WHOLE);
            return &self.output;
        }
        let whole = self.stepping.settings;
        let (mut report, mut impact) = (NO_STEP, None);
        for part in Share::all(of) {
            self.take(&part.input(&whole, input), part);
            report = together(report, self.output.report);
            impact = impact.or(self.output.impact);
            if report.outcome == StepOutcome::NonFinite {
                break;
            }
        }
        (self.output.report, self.output.impact) = (report, impact);
        &self.output
    }

    fn step_in_parts(&mut self, input: &mut InputDuring, observe: &mut dyn FnMut(&dyn Mechanism, bool)) -> StepReport {
        self.control = None;
        let whole = self.stepping.settings;
        let ask = |engine: &Self, part: Share, input: &mut InputDuring| {
            let h = part.settings(&whole).step;
            input(whole.step * part.begins(), h, &|| engine.site_position())
        };
        // Where nothing is known of parts yet, the input is that of the whole.
        let first = ask(self, Share::WHOLE, input);
        let of = self.core.choose(&first);
        let mut report = NO_STEP;
        for part in Share::all(of) {
            let own = if of == 1 { first } else { ask(self, part, input) };
            self.take(&own, part);
            report = together(report, self.output.report);
            if report.outcome == StepOutcome::NonFinite {
                break;
            }
            observe(self, part.is_last());
        }
        report
    }

    fn controlled_step(
        &mut self,
        accuracy: &Accuracy<f64>,
        limit: f64,
        ends: &dyn Fn(f64) -> f64,
        input: &mut InputDuring,
        observe: &mut dyn FnMut(&dyn Mechanism),
    ) -> ControlledStep<f64> {
        let Engine { core, stepping, control, .. } = self;
        core.sleep.wake();
        let control = control.get_or_insert_with(|| Box::new(Control::new(&stepping.settings)));
        let before = core.state.velocity;
        let (report, middle) = control.step(&core.model, &mut core.state, &stepping.settings, accuracy, limit, input);
        let Some(middle) = middle else { return report };
        core.report = StepReport { outcome: report.outcome, newton: report.newton, solver: report.solver };
        core.hand = control.hands[0];
        let end = core::mem::replace(&mut core.state, middle);
        self.arrive(before, ends(0.5 * report.step));
        observe(self);
        let before = self.core.state.velocity;
        self.core.state = end;
        if let Some(control) = &mut self.control {
            control.enter_second_half();
            self.core.hand = control.hands[1];
        }
        self.arrive(before, ends(report.step));
        observe(self);
        report
    }

    fn readout(&self) -> Readout<'_> {
        let Engine { core, stepping, contacts, output, .. } = self;
        Readout {
            now_s: core.clock.now_s,
            last_step_s: self.last().0.step,
            rests: core.rests(),
            bodies_rest: core.sleep.is_asleep() && core.was_left_out(),
            output,
            angles: &core.state.angle[..core.bodies],
            velocities: &core.state.velocity[..core.bodies],
            pivot_friction: &core.state.pivot_friction[..core.bodies],
            contacts: contacts.as_deref().map_or(&[], |contacts| contacts),
            tangential_forces: &core.state.tangential,
            stepping,
            surfaces: core.under.as_ref().map(|under| under.surfaces.as_ref()),
        }
    }

    fn configure(&mut self, stepping: Stepping) {
        self.core.sleep.wake();
        self.core.may_rest = stepping.may_rest;
        let lengths = |of: &Stepping| (of.settings.step, of.halving);
        if let Some(under) = self.core.under.as_mut().filter(|_| lengths(&stepping) != lengths(&self.stepping)) {
            under.prepare(stepping.settings.step, stepping.halving);
        }
        if stepping.settings != self.stepping.settings {
            self.control = None;
            self.taken = stepping.settings;
            self.core.set_clock(Clock::at(self.core.clock.now_s));
            self.forget_pose();
        }
        self.stepping = stepping;
        if !stepping.keeps_contacts {
            self.contacts = None;
        } else if self.contacts.is_none() {
            self.contacts = Some(Box::new([None; Z]));
            self.update_contacts();
        }
    }

    fn set(&mut self, part: StatePart) {
        match part {
            StatePart::Instant(now_s) => self.core.begin_at(now_s),
            StatePart::Standstill => {
                self.control = None;
                self.core.sleep.wake();
                self.core.state.velocity = [0.0; B];
            }
            StatePart::Hand(hand) => {
                self.core.sleep.wake();
                self.core.state.hand = hand;
            }
        }
        let report = self.core.report;
        self.update_output(report);
    }

    fn energies_at(&self, velocities: &[f64]) -> Energies {
        let mut state = self.core.state.clone();
        state.velocity[..self.core.bodies].copy_from_slice(velocities);
        self.core.energies(&state)
    }

    fn record_energy(&self, ledger: &mut Ledger) {
        let (settings, workspace) = self.last();
        let Stepped { model, state, velocity_before, under, .. } = &self.core;
        if let Some(contacts) = &self.contacts {
            ledger.record_contacts(model, settings, velocity_before, state, workspace, contacts);
            if let Some((hand, before)) = &self.core.hand {
                ledger.hand.record(model, settings, hand, before, velocity_before, state, workspace);
            }
        }
        if let Some(under) = under {
            ledger.record_surfaces(under.surfaces.lost(), under.surfaces.given());
        }
    }

    fn each_loss(&self, lose: &mut dyn FnMut(LossIn, f64)) {
        let (settings, workspace) = self.last();
        let Stepped { model, state, velocity_before, .. } = &self.core;
        if let Some(contacts) = &self.contacts {
            moreau::each_loss(model, settings, velocity_before, state, workspace, contacts, lose);
        }
    }

    fn save(&self) -> Saved {
        self.core.save()
    }

    fn restore(&mut self, saved: &Saved) {
        self.control = None;
        self.core.restore(saved);
        // What acted last is not part of it.
        self.workspace = Workspace::new();
        self.forget_pose();
        self.update_contacts();
        let report = self.core.report;
        self.update_output(report);
    }

    fn surfaces_mut(&mut self) -> Option<&mut (dyn Surfaces + 'static)> {
        self.core.sleep.wake();
        self.core.under.as_mut().map(|under| under.surfaces.as_mut())
    }
}

impl<const B: usize, const Z: usize, const N: usize> Observation for Engine<B, Z, N> {
    fn site_position(&self) -> f64 {
        site_position(&self.core.model, self.pose())
    }

    fn compression(&self, zone: usize) -> f64 {
        self.pose().compression(&self.core.model, zone)
    }

    fn normal_force(&self, zone: usize) -> f64 {
        let (settings, workspace) = self.last();
        workspace.normal_force(&self.core.model, settings, zone)
    }

    fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2] {
        self.pose().point(body.unwrap_or(GROUND), point)
    }

    fn compression_row(&self, zone: usize) -> Vec<f64> {
        self.pose().compression_row(&self.core.model, zone)[..self.core.bodies].to_vec()
    }

    fn contact_point(&self, zone: usize) -> [f64; 2] {
        self.pose().contact_point(&self.core.model, zone)
    }

    fn velocity_row(&self, body: usize, point: [f64; 2], n: [f64; 2]) -> Vec<f64> {
        self.pose().velocity_row(&self.core.model, body, point, n)[..self.core.bodies].to_vec()
    }
}
