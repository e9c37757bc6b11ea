//! Many mechanisms, stepped one after the other; those that nothing changes sleep.
//!
//! A step is a function of state and input. Where it left a state identical to the bit, every further step with the
//! identical input would do so too: the mechanism sleeps, and is not stepped until its input changes. That is exact,
//! not a threshold, and it happens, because dry friction as a set-valued law truly sticks: what rests comes to
//! velocities of exactly zero in finite time. Under a regularised friction law it does not, and nothing ever sleeps.
//! Nor does a mechanism that friction holds exactly at its limit, where rounding lets it slip and stick in turn
//! (velocities of 1e-17 rad/s that move no angle): rare, and then merely not for free.

use moreau::{Input, ModelError, Outcome, Settings, Workspace};

use crate::engine::{Clock, NO_STEP, Share, Stepped, together};
use crate::mechanism::{Saved, StepOutput};
use crate::size::with_size;
use crate::surfaces::{Halving, Surfaces, Under};
use crate::{Impact, OwnedDescription, Probes, Size};

/// Report of one step of a bank.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tick {
    /// Mechanisms that were stepped; the others slept.
    pub stepped: u32,
    /// Number of these whose step reached an iteration limit.
    pub unconverged: u32,
    /// Number of these that stayed where they were, because a number was not finite.
    pub non_finite: u32,
}

/// Many mechanisms of one size, each with an input that holds until it is changed. Indices count from 0. Only [`bank`]
/// allocates, and what says so.
pub trait Bank: Send {
    /// Number of mechanisms.
    fn count(&self) -> usize;
    /// The settings that all are stepped with.
    fn settings(&self) -> &Settings<f64>;
    /// The present instant, s.
    fn now_s(&self) -> f64;
    /// The mechanisms that are awake: the next step steps these.
    fn awake(&self) -> &[usize];
    /// Whether one is awake.
    fn is_awake(&self, index: usize) -> bool;
    /// What drives one from the next step on. Wakes it if that is anything new.
    fn drive(&mut self, index: usize, input: &Input<f64>);
    /// Places one's hand: world coordinate along the drive's direction, m, and velocity, m/s. Wakes it.
    fn place_hand(&mut self, index: usize, hand: [f64; 2]);
    /// Whether what nothing changes sleeps, as at first. Otherwise all are stepped in every step, with the same
    /// results.
    fn let_sleep(&mut self, sleep: bool);
    /// Sets the number of halvings of a step while something is near a compliant surface, from the next step on; as the
    /// surfaces ask, at first. Wakes all. May allocate.
    fn halve(&mut self, halving: Halving);
    /// Steps all that are awake; `impact` is called with every one whose marked point has met its zone.
    fn step(&mut self, impact: &mut dyn FnMut(usize, Impact)) -> Tick;
    /// Output of one's last step.
    fn output(&self, index: usize) -> StepOutput;
    /// Absolute angles of one, rad.
    fn angles(&self, index: usize) -> &[f64];
    /// Absolute angular velocities of one, rad/s.
    fn velocities(&self, index: usize) -> &[f64];
    /// All that the following steps of one depend on.
    fn save(&self, index: usize) -> Saved;
    /// One goes on from there, to the bit, and is awake.
    fn restore(&mut self, index: usize, saved: &Saved);
    /// The compliant subsystem under one's zones, where there is one.
    fn surfaces(&self, index: usize) -> Option<&dyn Surfaces>;
    /// The same, to be changed; wakes it.
    fn surfaces_mut(&mut self, index: usize) -> Option<&mut (dyn Surfaces + 'static)>;
    /// From now on one's zones press on these; wakes it.
    fn set_surfaces(&mut self, index: usize, surfaces: Box<dyn Surfaces>);
}

/// Assembles mechanisms, each awake and undriven; all in the size of the largest.
///
/// # Errors
/// The index of one that no size holds, or that is not sound, and what is wrong.
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
        Ok(Member { core, probes: *probes, input: Input::Free, awake: true, drive_n: 0.0, zone_n: 0.0 })
    });
    let members = each.collect::<Result<Vec<_>, _>>()?;
    let awake = (0..members.len()).collect();
    let halving = Halving::AsAsked;
    Ok(Box::new(Members { members, awake, sleep: true, settings, halving, workspace, clock: Clock::at(0.0) }))
}

struct Member<const B: usize, const Z: usize> {
    core: Stepped<B, Z>,
    probes: Probes,
    input: Input<f64>,
    awake: bool,
    /// Forces in the last step, N: of the drive, of the marked zone.
    drive_n: f64,
    zone_n: f64,
}

struct Members<const B: usize, const Z: usize, const N: usize> {
    members: Vec<Member<B, Z>>,
    /// Those that are awake, in no order: none feels another.
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

    fn drive(&mut self, index: usize, input: &Input<f64>) {
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
            let Member { core, probes, input, awake: is_awake, drive_n, zone_n } = &mut members[index];
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
                    *zone_n = probes.zone.map_or(0.0, |zone| workspace.normal_force(&core.model, &own, zone));
                }
                found = found.or(core.impact());
            }
            tick.stepped += 1;
            match report.outcome {
                Outcome::Converged => {}
                Outcome::IterationLimit => tick.unconverged += 1,
                Outcome::NonFinite | Outcome::TooManyLaws => tick.non_finite += 1,
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
        (member.drive_n, member.zone_n) = (0.0, 0.0);
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
