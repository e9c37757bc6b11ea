//! The step across a switch that is just ahead, in plain numbers.

use super::switch::{Before, Change, Slips, SwitchingLaw};
use super::{Driven, Tangent, plain};
use crate::settings::Settings;
use crate::state::State;

/// A step that is too short is doubled, and one in which several laws switch is halved, at most so often.
const TRIES: u32 = 28;

/// Steps beyond a switch are no shorter than this part of those before it.
const LEAST: f64 = 1e-4;

/// A step across a switch.
pub(super) struct Crossing<const B: usize, const Z: usize> {
    pub law: SwitchingLaw,
    /// How fast the law's slip changes before it.
    pub rate: f64,
    /// Length of the step, s.
    pub length: f64,
    /// Other laws that switch in it, too: they could not be distinguished.
    pub together: u32,
    pub after: State<f64, B, Z>,
}

impl<const B: usize, const Z: usize, const N: usize, const D: usize> Tangent<B, Z, N, D> {
    /// The shortest step that is found in which a law switches, so that no other one does. `slips`: after two steps of
    /// the length `small` up to here. None where no law that slips toward its switch reaches it within `far` s.
    pub(super) fn cross(
        &mut self,
        settings: &Settings<f64>,
        from: f64,
        slips: &[Slips<B, Z, D>; 2],
        [small, far]: [f64; 2],
        input: &mut Driven<'_, D>,
    ) -> Option<Crossing<B, Z>> {
        let before = Before::of(&self.plain, &plain(&self.state));
        let approach = |law| {
            let [u0, u1] = [slips[0].slip(law).value, slips[1].slip(law).value];
            (law, u1, (u1 - u0) / small)
        };
        let until = |(_, u, rate): &(SwitchingLaw, f64, f64)| (u / rate).abs();
        let (mut low, mut high) = (0.0, 2.0 * small);
        let mut found: Option<Crossing<B, Z>> = None;
        for _ in 0..TRIES {
            let length = if found.is_some() { 0.5 * (low + high) } else { high };
            let drive = input(from, length, self.site());
            let after = self.probe(settings, length, &drive);
            let laws = before.changes(&self.plain, &self.probe, &after).filter_map(Change::switch).map(approach);
            let (mut first, mut count): (Option<(SwitchingLaw, f64, f64)>, u32) = (None, 0);
            for one in laws.filter(|(_, u, rate)| u * rate < 0.0) {
                count += 1;
                if first.is_none_or(|first| until(&one) < until(&first)) {
                    first = Some(one);
                }
            }
            match first {
                Some((law, _, rate)) => {
                    found = Some(Crossing { law, rate, length, after, together: count - 1 });
                    if count == 1 {
                        break;
                    }
                    high = length;
                }
                None if found.is_some() => low = length,
                None if length > far => break,
                None => (low, high) = (length, 2.0 * length),
            }
        }
        found
    }

    /// Two steps beyond a switch, and how long each is, s: as long as the step across, or so much shorter that no other
    /// law switches in them. A contact that sticks has turned since the middle of the step across: to be held in a much
    /// shorter one, it would need a force as many times as large.
    pub(super) fn beyond(
        &mut self,
        settings: &Settings<f64>,
        from: f64,
        after: &State<f64, B, Z>,
        [length, small]: [f64; 2],
        law: SwitchingLaw,
        input: &mut Driven<'_, D>,
    ) -> (State<f64, B, Z>, State<f64, B, Z>, f64) {
        let (site, mut ahead) = (self.site(), length.max(small));
        loop {
            let mut clear = true;
            let mut on = |start: &State<f64, B, Z>, last: f64, now: f64| {
                let end = self.probe_from(start, last, settings, ahead, &input(from + now, ahead, site));
                let before = Before::of(&self.plain, start);
                let unlike = |change: Change| change.switch().is_some_and(|other| other != law);
                clear &= !before.changes(&self.plain, &self.probe, &end).any(unlike);
                end
            };
            let first = on(after, length, length);
            let second = on(&first, ahead, length + ahead);
            if clear || ahead < LEAST * small {
                return (first, second, ahead);
            }
            ahead *= 0.25;
        }
    }
}
