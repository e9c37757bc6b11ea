//! Pianos unknown to the program, put out of order, and put right again by its list.
//!
//! A healthy grand of the ensemble is disturbed as pianos are. The program gets readings only, each off by the error of
//! a hand and an eye. The list is worked out on a twin of the built-in grand, which is another instrument, and carried
//! out on the disturbed one by a hand that is off by up to half its step, and turns until it reads what the list
//! promises; then all is measured again.

use std::collections::BTreeMap;

use erard::instrument::Instrument;
use erard_workshop::balance::Lead;
use erard_workshop::worklist::{Item, Left, Priority, ReadingQuantity, Readings, Why, Work, twin, worklist};

use super::hand::{Chance, KEY, by_hand, correct_aftertouch, read_once_more, seen};

/// The disturbances of a piano.
#[derive(Debug, Clone)]
pub struct Disturbed {
    pub instrument: Instrument,
    pub leads: Vec<Lead>,
    pub what: Vec<String>,
}

/// Applies each disturbance to two pianos of five, and at least one to each piano.
pub fn disturb(healthy: &Instrument, chance: &mut Chance) -> Disturbed {
    const SHARE: f64 = 0.4;
    // The file's own two, 0.62 and 0.55 of the key's front arm.
    let mut leads = vec![Lead { mass_g: 14.0, at_mm: 164.0 }, Lead { mass_g: 14.0, at_mm: 146.0 }];
    let (mut instrument, mut what) = (healthy.clone(), Vec::new());
    while what.is_empty() {
        // Screws worked loose or turned by somebody, mm.
        for (screw, most_mm) in [
            ("capstan_height", 0.4),
            ("let_off", 0.5),
            ("drop", 0.4),
            ("jack_position", 0.5),
            ("lever_height", 0.4),
            ("damper_timing", 1.0),
            ("back_check", 0.5),
        ] {
            if chance.happens(SHARE / 2.0) {
                let by_mm = most_mm * chance.either_way();
                turn(&mut instrument, screw, 1e-3 * by_mm);
                what.push(format!("{screw} {by_mm:+.2} mm"));
            }
        }
        // Packed cloths, mm: front punchings, back rail, the whippen's heel.
        for (screw, most_mm) in [("front_punching", 0.8), ("back_rail_cloth", 0.6), ("capstan_height", 0.3)] {
            if chance.happens(SHARE / 2.0) {
                let by_mm = -most_mm * chance.share();
                turn(&mut instrument, screw, 1e-3 * by_mm);
                what.push(format!("cloth at {screw} {by_mm:.2} mm"));
            }
        }
        // A weakened or bent spring.
        if chance.happens(SHARE) {
            let by = chance.between(-0.25, 0.15) * instrument.springs[0].torque_n_m.abs();
            turn(&mut instrument, "repetition_spring", by);
            what.push(format!("spring {:+.1} N mm", 1e3 * by));
        }
        // Swollen or worn pins and bushings.
        for (body, most) in [("key", 4.0), ("key_back", 4.0), ("whippen", 4.0), ("shank", 3.0), ("hammer", 3.0)] {
            let pinned = instrument.bodies.iter().position(|own| own.name == body && own.parent.is_none());
            if let Some(pinned) = pinned
                && chance.happens(SHARE / 2.0)
            {
                let factor = if chance.happens(0.75) { chance.between(1.3, most) } else { chance.between(0.3, 0.8) };
                instrument.edit(|fields| fields.bodies[pinned].friction_torque_n_m *= factor).unwrap();
                what.push(format!("friction of {body} x {factor:.1}"));
            }
        }
        // A lead put in, taken out, or moved.
        if chance.happens(SHARE) {
            let work = match chance.next() % 3 {
                0 => {
                    let lead = Lead { mass_g: 10.0, at_mm: chance.between(60.0, 120.0).round() };
                    leads.push(lead);
                    (vec![], vec![lead])
                }
                1 => (vec![leads.remove(1)], vec![]),
                _ => {
                    let moved = Lead { at_mm: (leads[1].at_mm - chance.between(20.0, 90.0)).round(), ..leads[1] };
                    let old = std::mem::replace(&mut leads[1], moved);
                    (vec![old], vec![moved])
                }
            };
            what.push(format!("leads out {:?} in {:?}", work.0, work.1));
            let lead_work = erard_workshop::balance::LeadWork { out: work.0, put: work.1, ..Default::default() };
            Work::Leads(lead_work).carry_out(&mut instrument, &mut |_| true).unwrap();
        }
    }
    Disturbed { instrument, leads, what }
}

fn turn(instrument: &mut Instrument, name: &str, by: f64) {
    if let Some(screw) = instrument.screw(name) {
        let setting = instrument.screws[screw].setting + by;
        assert!(instrument.turn(screw, setting), "{name}");
    }
}

/// Result of one pass: the lines left, and the truth after it.
pub struct Pass {
    /// Lines as carried out.
    pub lines: Vec<String>,
    /// Lines left, and why.
    pub left: Vec<Left>,
    /// Whether the check caught the hammer no farther out than it stands, as the sheet allows.
    pub caught_no_farther: bool,
    /// Readings before the pass.
    pub read: Readings,
    /// Truth after the pass.
    pub truth: Readings,
}

/// Reads the piano, works out its list, and carries it out by hand.
pub fn pass(piano: &mut Instrument, leads: &mut Vec<Lead>, model: &Instrument, chance: &mut Chance) -> Pass {
    let go_on = &mut |_: f64| true;
    let mut truth = Readings::of(piano, go_on).unwrap();
    let read = seen(&truth, chance);
    let twin = twin(model, &read, go_on).unwrap();
    let list = worklist(&twin, &read, leads, Priority::Aftertouch, go_on).unwrap();
    super::assert_lines_can_be_seen(&list);
    let front_mm = 1e3 * piano.roles.key_front_m[0].abs();
    let (mut lines, mut caught_no_farther) = (Vec::new(), false);
    let is_screw = |item: &Item| matches!(item.work, Work::Screw { .. });
    let last_screw = list.items.iter().rposition(is_screw);
    let decided = list.aftertouch_is_decided_by();
    for (at, item) in list.items.iter().enumerate() {
        let is_unreadable = |left: &Left| left.quantity == item.quantity && left.why == Why::Unreadable;
        let can_be_read = !list.left.iter().any(is_unreadable) || item.quantity == ReadingQuantity::Check;
        let done = by_hand(item, can_be_read, piano, &mut truth, front_mm, chance);
        caught_no_farther |= done.caught_no_farther;
        for work in &done.works {
            if let Work::Leads(work) = work {
                leads.retain(|lead| !work.out.contains(lead));
                leads.extend(&work.put);
            }
        }
        lines.push(format!("{:?}: {:?}", item.quantity, item.work));
        if decided == Some(at) {
            correct_aftertouch(piano, &mut truth, chance);
        }
        if last_screw == Some(at) {
            caught_no_farther |= read_once_more(&list, piano, &mut truth, front_mm, chance);
        }
    }
    Pass { lines, left: list.left, caught_no_farther, read, truth }
}

/// The outcome for one piano.
pub struct Course {
    pub what: Vec<String>,
    pub before: Readings,
    pub passes: Vec<Pass>,
}

/// Whether all true values are in order.
pub fn is_healthy(readings: &Readings) -> bool {
    ReadingQuantity::ALL.into_iter().all(|quantity| !readings.is_out(quantity, KEY))
}

/// Puts a healthy piano out of order and works on it twice.
pub fn course(healthy: &Instrument, model: &Instrument, seed: u64) -> Course {
    let mut chance = Chance::new(seed);
    let Disturbed { mut instrument, mut leads, what } = disturb(healthy, &mut chance);
    let before = Readings::of(&instrument, &mut |_| true).unwrap();
    let passes = (0..2).map(|_| pass(&mut instrument, &mut leads, model, &mut chance)).collect();
    Course { what, before, passes }
}

/// The outcome of the list for many pianos.
#[derive(Debug, Default)]
pub struct Tally {
    pub pianos: usize,
    pub lines: usize,
    /// Lines inside before, after one pass, after two.
    pub inside: [usize; 3],
    /// Lines outside after one pass, and after two, by quantity.
    pub outside: BTreeMap<ReadingQuantity, [usize; 2]>,
    /// Outside after two passes, with a reason stated or read as inside.
    pub with_reason: usize,
    /// Outside after two passes without a reason.
    pub without_reason: Vec<String>,
    /// Moved out of its range, or further out, by more than its precision in a pass.
    pub made_worse: Vec<String>,
}

impl Tally {
    pub fn add(&mut self, number: u32, course: &Course) {
        self.pianos += 1;
        let truths = [&course.before, &course.passes[0].truth, &course.passes[1].truth];
        for quantity in ReadingQuantity::ALL {
            self.lines += 1;
            for (count, truth) in self.inside.iter_mut().zip(truths) {
                *count += usize::from(!truth.is_out(quantity, KEY));
            }
            for (pass, pair) in truths.windows(2).enumerate() {
                self.outside.entry(quantity).or_default()[pass] += usize::from(pair[1].is_out(quantity, KEY));
                let [before, after] = [pair[0], pair[1]].map(|truth| truth.beyond(quantity, KEY));
                let worked = &course.passes[pass];
                // An unreadable line has no reading before the pass: if the hammer does not drop, its nearest approach
                // is the lever's, and the jack's let-off shows once it drops.
                let stated = worked.left.iter().any(|left| left.quantity == quantity && left.why == Why::Unreadable);
                if after > before + quantity.precision() && !stated {
                    self.made_worse.push(format!(
                        "piano {number} ({:?}), pass {}: {quantity:?} {:?} (read {:?}) -> {:?} by {:?}",
                        course.what,
                        pass + 1,
                        pair[0].get(quantity),
                        worked.read.get(quantity),
                        pair[1].get(quantity),
                        worked.lines
                    ));
                }
            }
            let last = &course.passes[1];
            if last.truth.is_out(quantity, KEY) {
                let within_reading = last.truth.beyond(quantity, KEY) <= quantity.precision();
                let stated = last.left.iter().any(|left| left.quantity == quantity)
                    || quantity == ReadingQuantity::Check && last.caught_no_farther;
                if within_reading || stated {
                    self.with_reason += 1;
                } else {
                    self.without_reason.push(format!("piano {number}: {quantity:?} {:?}", last.truth.get(quantity)));
                }
            }
        }
    }

    /// Counts in words.
    pub fn counts(&self) -> String {
        let share = |count: usize| 100.0 * count as f64 / self.lines.max(1) as f64;
        let [before, one, two] = self.inside;
        format!(
            "{} pianos, {} lines: inside before {before} ({:.1} %), after one pass {one} ({:.1} %), after two {two} \
             ({:.1} %); outside then with a reason {}, without {}; made worse {}",
            self.pianos,
            self.lines,
            share(before),
            share(one),
            share(two),
            self.with_reason,
            self.without_reason.len(),
            self.made_worse.len()
        )
    }

    /// Failures.
    pub fn wrong(&self) -> impl Iterator<Item = &String> {
        self.without_reason.iter().chain(&self.made_worse)
    }

    /// Counts and failures in words.
    pub fn report(&self) -> String {
        let outside = self.outside.iter().filter(|(_, count)| **count != [0; 2]);
        let counts = outside.fold(self.counts(), |text, (quantity, [one, two])| {
            format!("{text}\n  {quantity:?} outside: {one} after one pass, {two} after two")
        });
        self.wrong().fold(counts, |report, line| format!("{report}\n  {line}"))
    }
}
