//! Combinations of features in a run: plays every line of the table in `docs/notes/combinations.md`.

use erard::gradient::{Direction, GradientError, How, Poses, STACK_BYTES, check, follow};
use erard::instrument::Dwell;
use erard::player::{Hand, Inside, LossRecorder, ReactionRecorder};
use erard::run::{Events, simulate_observed};
use erard::{Input, Instrument, Setup};
use erard_workshop::study::{Job, Lanes, Workers, play_all};

const FEATURES: [&str; 8] =
    ["strings", "hand", "adaptive steps", "lanes", "derivatives", "dwell", "losses", "reactions"];

/// Combinations that no function accepts.
const ABSENT: [[&str; 2]; 5] = [
    ["lanes", "derivatives"],
    ["lanes", "losses"],
    ["lanes", "reactions"],
    ["derivatives", "losses"],
    ["derivatives", "reactions"],
];

/// A force that rises within 20 ms: a mezzo forte.
fn stroke(t: f64) -> Input {
    Input::Force(6.0 * (t / 0.02).min(1.0))
}

struct Asked {
    instrument: Instrument,
    setup: Setup,
    both: [&'static str; 2],
}

impl Asked {
    fn of(both: [&'static str; 2]) -> Self {
        let has = |name: &str| both.contains(&name);
        let name = if has("strings") { "concert-grand-strings" } else { "concert-grand" };
        let mut instrument = Instrument::builtin(name).unwrap();
        if has("dwell") {
            let dwell = Some(Dwell { ratio: 1.3, time_s: 0.2 });
            instrument
                .edit(|fields| {
                    fields.bodies.iter_mut().filter(|b| b.friction_torque_n_m > 0.0).for_each(|b| b.dwell = dwell);
                    fields.zones.iter_mut().filter(|z| z.friction_coefficient > 0.0).for_each(|z| z.dwell = dwell);
                })
                .unwrap();
        }
        let setup = Setup {
            hand: has("hand").then(Hand::default),
            tolerance: has("adaptive steps").then_some(1e-4),
            ..Setup::new(0.08)
        };
        Asked { instrument, setup, both }
    }

    fn has(&self, name: &str) -> bool {
        self.both.contains(&name)
    }

    fn press(&self) -> Result<Events, String> {
        erard::press(&self.instrument, &stroke, &self.setup).map(|run| run.events).map_err(|error| error.to_string())
    }

    /// The table's entry for both.
    fn answer(&self) -> String {
        if ABSENT.contains(&self.both) {
            return "absent".to_owned();
        }
        if self.has("derivatives") {
            return self.derive();
        }
        if self.has("lanes") {
            return self.play_in_lanes();
        }
        let alone = match self.press() {
            Ok(events) => events,
            Err(_) => return "refused".to_owned(),
        };
        assert!((1.0..4.0).contains(&alone.hammer_speed_m_per_s().unwrap()), "{:?}: {alone:?}", self.both);
        if self.has("losses") || self.has("reactions") {
            let mut inside = Inside {
                reactions: self.has("reactions").then(|| ReactionRecorder::new(&self.instrument)),
                losses: self.has("losses").then(|| LossRecorder::new(&self.instrument)),
            };
            let run = simulate_observed(&self.instrument, &stroke, &self.setup, &mut inside, &mut |_| true).unwrap();
            // Observers change nothing, and report something.
            assert_eq!(run.events, alone, "{:?}", self.both);
            if let Some(losses) = &inside.losses {
                let lost: f64 = losses.losses().unwrap().by_size().iter().map(|loss| loss.all_j()).sum();
                let booked = run.ledger.as_ref().unwrap().dissipated();
                assert!((lost / booked - 1.0).abs() < 1e-6, "{:?}: {lost} {booked}", self.both);
            }
            if let Some(reactions) = inside.reactions {
                assert_eq!(reactions.into_series().len(), self.instrument.bodies.len());
            }
        }
        "yes".to_owned()
    }

    fn play_in_lanes(&self) -> String {
        let alone = self.press();
        let jobs = (0..8).map(|_| Job { instrument: 0, stroke: Box::new(stroke) }).collect();
        let (instruments, workers) = ([self.instrument.clone()], Workers { threads: 1, lanes: Lanes::most() });
        let played = play_all(&instruments, jobs, &self.setup, workers, &mut |_| true).unwrap();
        let events = match played.into_iter().next().unwrap() {
            Ok(played) => played.events,
            Err(_) => return "refused".to_owned(),
        };
        let [here, there] = [alone.unwrap(), events].map(|events| events.hammer_speed_m_per_s().unwrap());
        assert!((here / there - 1.0).abs() < 1e-6, "{:?}: {here} {there}", self.both);
        // Lanes round products and sums at once; an action played alone has the bits of a press. Without lanes in the
        // processor this cannot be checked.
        let in_lanes =
            here != there || (Lanes::most() == Lanes::One && !self.has("strings") && !self.has("adaptive steps"));
        if in_lanes { "yes" } else { "one by one" }.to_owned()
    }

    fn derive(&self) -> String {
        let (instrument, setup) = (self.instrument.clone(), self.setup);
        let followed = std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn(move || -> Result<_, GradientError> {
                check(&instrument)?;
                let poses = Poses::of(&instrument, 0.0, &mut |_| true)?;
                follow(&instrument, &[Direction::force()], &stroke, &setup, &poses, How::default(), &mut |_| true)
            })
            .unwrap()
            .join()
            .unwrap();
        match followed {
            Err(_) => "refused".to_owned(),
            Ok(followed) => {
                let speed = followed.instants.hammer_speed_m_per_s.unwrap();
                let events = self.press().unwrap();
                assert!((speed.value / events.hammer_speed_m_per_s().unwrap() - 1.0).abs() < 1e-3, "{:?}", self.both);
                // A stronger finger is faster.
                assert!(speed.slope[0] > 0.0, "{speed:?}");
                "yes".to_owned()
            }
        }
    }
}

#[test]
fn the_notes_table_is_what_happens() {
    let note = include_str!("../../../../docs/notes/combinations.md");
    let lines: Vec<Vec<&str>> = note
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.strip_suffix(" |"))
        .map(|line| line.split(" | ").collect())
        .filter(|cells: &Vec<&str>| FEATURES.contains(&cells[0]))
        .collect();
    let mut pairs = Vec::new();
    for (i, first) in FEATURES.into_iter().enumerate() {
        for second in FEATURES.into_iter().skip(i + 1) {
            pairs.push([first, second]);
        }
    }
    assert_eq!(lines.iter().map(|cells| [cells[0], cells[1]]).collect::<Vec<_>>(), pairs);
    for (cells, both) in lines.iter().zip(pairs) {
        let said = cells[2].split(':').next().unwrap();
        assert_eq!(Asked::of(both).answer(), said, "{both:?}");
    }
}
