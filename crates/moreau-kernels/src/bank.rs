//! A bank of mechanisms, stepped one after the other. A mechanism sleeps while its steps would change nothing.
//!
//! A step is a function of state and input. If a step leaves every bit of a mechanism's state unchanged, so would the
//! next one with the same input. Such a mechanism sleeps: it is skipped until its input changes. This is exact; there
//! is no threshold. It works because set-valued dry friction brings velocities to exactly zero in finite time, or,
//! where something slips at the limit of its friction toward its rest (a damper that sinks into its felt), to such that
//! no longer change an angle by rounding: 1e-15 rad/s, for ever. Regularised friction does neither: under it no
//! mechanism ever sleeps. Rounding can make such a velocity alternate between two or three values, which differ by
//! 1e-18 rad/s: [`moreau::step_or_stay`].

use moreau::{ModelError, Settings, SiteInput, StepOutcome, Workspace};

use crate::engine::{Clock, NO_STEP, Share, Stepped, together};
use crate::mechanism::{Saved, StepOutput};
use crate::size::with_size;
use crate::surfaces::{Halving, Surfaces, Under};
use crate::{Impact, OwnedDescription, Probes, Size};

/// Report of one step of a bank.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Tick {
    /// Number of mechanisms that were stepped; the others slept.
    pub stepped: u32,
    /// Number of stepped mechanisms whose step reached an iteration limit.
    pub unconverged: u32,
    /// Number of stepped mechanisms whose state did not change because a number became infinite or NaN.
    pub non_finite: u32,
}

/// Many mechanisms of one size, each with an input that acts until it is changed. Indices count from 0. Only [`bank`]
/// allocates, and the functions that say so.
pub trait Bank: Send {
    /// Returns the number of mechanisms.
    fn count(&self) -> usize;
    /// Returns the settings of all steps.
    fn settings(&self) -> &Settings<f64>;
    /// Returns the present instant, s.
    fn now_s(&self) -> f64;
    /// Returns the mechanisms that are awake. The next step advances these.
    fn awake(&self) -> &[usize];
    /// Returns whether a mechanism is awake.
    fn is_awake(&self, index: usize) -> bool;
    /// Sets the input of a mechanism from the next step on. Wakes it if the input changes.
    fn drive(&mut self, index: usize, input: &SiteInput<f64>);
    /// Sets the hand of a mechanism: world coordinate along the drive's direction, m, and velocity, m/s. Wakes it.
    fn place_hand(&mut self, index: usize, hand: [f64; 2]);
    /// Sets whether mechanisms may sleep; true at first. If false, every step advances all of them, with the same
    /// results.
    fn let_sleep(&mut self, sleep: bool);
    /// Sets how steps are halved near a compliant surface, from the next step on; at first, as the surfaces request.
    /// Wakes all mechanisms if this changes. May allocate.
    fn halve(&mut self, halving: Halving);
    /// Advances all mechanisms that are awake by one step. Calls `impact` for each one whose probe point has hit its
    /// zone.
    fn step(&mut self, impact: &mut dyn FnMut(usize, Impact)) -> Tick;
    /// Sets the zones of a mechanism whose normal forces every step adds up; none at first. Allocates.
    fn listen(&mut self, index: usize, zones: &[usize]);
    /// Returns by how much this sum, N, has changed since a mechanism's first step of those that listen, but for the
    /// first step after [`Bank::restore`].
    fn listened_n(&self, index: usize) -> f64;
    /// Returns the output of a mechanism's last step.
    fn output(&self, index: usize) -> StepOutput;
    /// Returns the absolute angles of a mechanism's bodies, rad.
    fn angles(&self, index: usize) -> &[f64];
    /// Returns the absolute angular velocities of a mechanism's bodies, rad/s.
    fn velocities(&self, index: usize) -> &[f64];
    /// Returns everything that the following steps of a mechanism depend on, except for its surfaces.
    fn save(&self, index: usize) -> Saved;
    /// Restores a saved mechanism, to the bit, at the bank's present instant. Wakes it.
    fn restore(&mut self, index: usize, saved: &Saved);
    /// Returns the compliant external subsystem under a mechanism's zones; `None` if there is none.
    fn surfaces(&self, index: usize) -> Option<&dyn Surfaces>;
    /// Returns the subsystem under a mechanism's zones for changes. Wakes the mechanism.
    fn surfaces_mut(&mut self, index: usize) -> Option<&mut (dyn Surfaces + 'static)>;
    /// Places a subsystem under a mechanism's zones. Wakes the mechanism.
    fn set_surfaces(&mut self, index: usize, surfaces: Box<dyn Surfaces>);
}

/// Assembles a bank of mechanisms, all in the size that holds the largest. Each is awake and has no drive.
///
/// # Errors
/// Returns the index of a mechanism that is too large for every size or is unsound, with its [`ModelError`].
pub fn bank(
    descriptions: &[OwnedDescription],
    probes: &[Probes],
    settings: Settings<f64>,
) -> Result<Box<dyn Bank>, (usize, ModelError)> {
    let size = descriptions.iter().map(Size::of).max().unwrap_or(Size::One);
    with_size!(size, boxed, descriptions, probes, settings)
}

fn boxed<const B: usize, const Z: usize, const N: usize>(
    descriptions: &[OwnedDescription],
    probes: &[Probes],
    settings: Settings<f64>,
) -> Result<Box<dyn Bank>, (usize, ModelError)> {
    let workspace = Workspace::<f64, B, Z, N>::new();
    let each = descriptions.iter().zip(probes).enumerate().map(|(i, (description, probes))| {
        let core: Stepped<B, Z> = Stepped::new(description, probes).map_err(|error| (i, error))?;
        // Room for its laws.
        Workspace::<f64, B, Z, N>::for_model(&core.model).map_err(|error| (i, error))?;
        let (zones, input) = (Vec::new(), SiteInput::Free);
        let (zones_n, listened_n) = (None, 0.0);
        Ok(Member { core, probes: *probes, zones, input, awake: true, drive_n: 0.0, zone_n: 0.0, zones_n, listened_n })
    });
    let members = each.collect::<Result<Vec<_>, _>>()?;
    let awake = (0..members.len()).collect();
    let halving = Halving::Auto;
    Ok(Box::new(Members { members, awake, sleep: true, settings, halving, workspace, clock: Clock::at(0.0) }))
}

struct Member<const B: usize, const Z: usize> {
    core: Stepped<B, Z>,
    probes: Probes,
    /// Zones whose forces are added up.
    zones: Vec<usize>,
    input: SiteInput<f64>,
    awake: bool,
    /// Forces in the last step, N: of the drive, of the probe zone, of the zones that are added up.
    drive_n: f64,
    zone_n: f64,
    zones_n: Option<f64>,
    /// By how much the last has changed, N.
    listened_n: f64,
}

struct Members<const B: usize, const Z: usize, const N: usize> {
    members: Vec<Member<B, Z>>,
    /// Mechanisms that are awake, in no order: none depends on another.
    awake: Vec<usize>,
    sleep: bool,
    settings: Settings<f64>,
    halving: Halving,
    workspace: Workspace<f64, B, Z, N>,
    clock: Clock,
}

impl<const B: usize, const Z: usize, const N: usize> Members<B, Z, N> {
    fn wake(&mut self, index: usize) {
        let member = &mut self.members[index];
        if !member.awake {
            member.awake = true;
            member.core.sleep_ended(self.clock);
            // There is room: none is in the list twice.
            self.awake.push(index);
        }
    }
}

impl<const B: usize, const Z: usize, const N: usize> Bank for Members<B, Z, N> {
    fn count(&self) -> usize {
        self.members.len()
    }

    fn settings(&self) -> &Settings<f64> {
        &self.settings
    }

    fn now_s(&self) -> f64 {
        self.clock.now_s
    }

    fn awake(&self) -> &[usize] {
        &self.awake
    }

    fn is_awake(&self, index: usize) -> bool {
        self.members[index].awake
    }

    fn drive(&mut self, index: usize, input: &SiteInput<f64>) {
        if !input.identical(&self.members[index].input) {
            self.members[index].input = *input;
            self.wake(index);
        }
    }

    fn place_hand(&mut self, index: usize, hand: [f64; 2]) {
        self.wake(index);
        let core = &mut self.members[index].core;
        core.sleep.wake();
        core.state.hand = hand;
    }

    fn let_sleep(&mut self, sleep: bool) {
        self.sleep = sleep;
        if !sleep {
            for index in 0..self.members.len() {
                self.wake(index);
            }
        }
    }

    fn halve(&mut self, halving: Halving) {
        if halving == self.halving {
            return;
        }
        self.halving = halving;
        for index in 0..self.members.len() {
            self.wake(index);
            if let Some(under) = &mut self.members[index].core.under {
                under.prepare(self.settings.step, halving);
            }
        }
    }

    fn step(&mut self, impact: &mut dyn FnMut(usize, Impact)) -> Tick {
        let Members { members, awake, sleep, settings, workspace, clock, .. } = self;
        let mut tick = Tick::default();
        let mut place = 0;
        while let Some(&index) = awake.get(place) {
            let Member { core, probes, zones, input, awake: is_awake, drive_n, zone_n, zones_n, listened_n } =
                &mut members[index];
            // Working memory holds another's contacts, and what is awake is stepped; but while something rings that is
            // out of its reach, it sleeps.
            if core.under.is_none() || !*sleep {
                core.sleep.wake();
            }
            let (mut report, mut found) = (NO_STEP, None);
            for part in Share::all(core.choose(input)) {
                let (own, input) = (part.settings(settings), part.input(settings, input));
                report = together(report, core.step(&own, &input, (settings.step, part), workspace));
                if !core.was_left_out() {
                    *drive_n = workspace.drive_force();
                    let force_n = |zone: usize| workspace.normal_force(&core.model, &own, zone);
                    *zone_n = probes.zone.map_or(0.0, force_n);
                    if !zones.is_empty() {
                        let sum_n: f64 = zones.iter().copied().map(force_n).sum();
                        *listened_n += sum_n - zones_n.replace(sum_n).unwrap_or(sum_n);
                    }
                }
                found = found.or(core.impact());
            }
            tick.stepped += 1;
            match report.outcome {
                StepOutcome::Converged => {}
                StepOutcome::IterationLimit => tick.unconverged += 1,
                StepOutcome::NonFinite | StepOutcome::TooManyLaws => tick.non_finite += 1,
            }
            if let Some(found) = found {
                impact(index, found);
            }
            if core.rests() && *sleep {
                *is_awake = false;
                awake.swap_remove(place);
            } else {
                place += 1;
            }
        }
        clock.tick(settings.step);
        tick
    }

    fn listen(&mut self, index: usize, zones: &[usize]) {
        let member = &mut self.members[index];
        (member.zones, member.zones_n) = (zones.to_vec(), None);
    }

    fn listened_n(&self, index: usize) -> f64 {
        self.members[index].listened_n
    }

    fn output(&self, index: usize) -> StepOutput {
        let Member { core, drive_n, zone_n, .. } = &self.members[index];
        core.output(*drive_n, *zone_n, core.report)
    }

    fn angles(&self, index: usize) -> &[f64] {
        let core = &self.members[index].core;
        &core.state.angle[..core.bodies]
    }

    fn velocities(&self, index: usize) -> &[f64] {
        let core = &self.members[index].core;
        &core.state.velocity[..core.bodies]
    }

    fn save(&self, index: usize) -> Saved {
        self.members[index].core.save_at(&self.clock)
    }

    fn restore(&mut self, index: usize, saved: &Saved) {
        self.members[index].core.restore(saved);
        let clock = self.clock;
        let member = &mut self.members[index];
        member.core.set_clock(clock);
        (member.drive_n, member.zone_n, member.zones_n) = (0.0, 0.0, None);
        self.wake(index);
    }

    fn surfaces(&self, index: usize) -> Option<&dyn Surfaces> {
        self.members[index].core.under.as_ref().map(|under| under.surfaces.as_ref())
    }

    fn surfaces_mut(&mut self, index: usize) -> Option<&mut (dyn Surfaces + 'static)> {
        self.wake(index);
        let core = &mut self.members[index].core;
        core.sleep.wake();
        core.under.as_mut().map(|under| under.surfaces.as_mut())
    }

    fn set_surfaces(&mut self, index: usize, surfaces: Box<dyn Surfaces>) {
        self.wake(index);
        let under = Under::new(surfaces, self.settings.step, self.halving);
        self.members[index].core.under = Some(under);
    }
}
