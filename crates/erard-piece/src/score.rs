//! A piece as a list of motions.

use erard_midi::file::{Note, PedalChange, Piece};
use erard_midi::message::{SOFT, SOSTENUTO, SUSTAIN};
use erard_midi::{Law, ReleaseLaw, Velocity};

/// The first hammer meets its string this long after the beginning, s, or later: the softest key strokes take 0.25 s.
pub const LEAD_S: f64 = 0.4;
/// Lift of the rail under a pressed sustain pedal, m: the dampers are 4.5 mm up then. An estimate.
pub const FULL_PEDAL_M: f64 = 7e-3;

/// A note to play.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrittenNote {
    /// The key, from 1.
    pub key: usize,
    /// Instant at which the hammer should meet the string, s from the performance's beginning.
    pub on_s: f64,
    /// Instant at which the rising key should set its damper down, s.
    pub off_s: f64,
    /// The velocity as written.
    pub velocity: Velocity,
    /// The hammer speed at the string that follows from it by the law, m/s.
    pub speed_m_per_s: f64,
    /// Speed of the key's front on its way up there, m/s, positive; `None` where the piece does not give it.
    pub release_m_per_s: Option<f64>,
}

/// The notes of a piece that begin between two instants, s; the first instant becomes its beginning. Pedals are where
/// they had been left.
#[must_use]
pub fn passage(piece: &Piece, from_s: f64, to_s: f64) -> Piece {
    let notes = piece.notes.iter().filter(|note| (from_s..to_s).contains(&note.start_s));
    let shifted = notes.map(|note| Note { start_s: note.start_s - from_s, end_s: note.end_s - from_s, ..*note });
    let pedals = piece.pedals.iter().filter(|change| change.time_s < to_s);
    let pedals = pedals.map(|change| PedalChange { time_s: (change.time_s - from_s).max(0.0), ..*change });
    Piece { notes: shifted.collect(), pedals: pedals.collect(), remarks: piece.remarks.within(from_s, to_s) }
}

/// A motion of a foot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PedalMove {
    /// The sustain pedal sends its rail to a lift, m.
    Sustain(f64),
    /// The sostenuto pedal goes down, or up.
    Sostenuto(bool),
}

/// A piece as motions of hands and feet.
#[derive(Debug, Clone, PartialEq)]
pub struct Score<'l> {
    /// The law between velocities and hammer speeds.
    pub law: Law<'l>,
    /// The notes in the order of their beginnings, then of their keys.
    pub notes: Vec<WrittenNote>,
    /// The feet in the order of time, s.
    pub(crate) feet: Vec<(f64, PedalMove)>,
    /// Shift of the piece that gives the first hand time to press, s; 0 if it has enough.
    pub shift_s: f64,
    /// When the last note ends, s.
    pub duration_s: f64,
    /// Omissions and repairs of the piece, a sentence each.
    pub remarks: Vec<String>,
}

impl<'l> Score<'l> {
    /// The sustain pedal: instants of its motions, s, and positions, from 0 (up) to 1 (down).
    #[must_use]
    pub fn sustain(&self) -> Vec<[f64; 2]> {
        let moved = |&(at_s, foot): &(f64, PedalMove)| match foot {
            PedalMove::Sustain(lift_m) => Some([at_s, lift_m / FULL_PEDAL_M]),
            PedalMove::Sostenuto(_) => None,
        };
        self.feet.iter().filter_map(moved).collect()
    }

    /// Converts a piece to motions, its velocities read by a law.
    ///
    /// The sustain pedal (controller 64) travels in proportion to its values; its rail follows as fast as a foot that
    /// stamps. The sostenuto pedal (66) holds the dampers that are up when it passes the middle of its way. The soft
    /// pedal (67) would shift the hammers to fewer strings and to another place of their felts, which the model does
    /// not have: a remark says how often it goes down, and how many notes should have been played with it.
    #[must_use]
    pub fn of(piece: &Piece, law: &Law<'l>) -> Self {
        let first_s = piece.notes.first().map_or(LEAD_S, |note| note.start_s);
        let shift_s = (LEAD_S - first_s).max(0.0);
        let notes = piece.notes.iter().map(|note| WrittenNote {
            key: note.key,
            on_s: note.start_s + shift_s,
            off_s: note.end_s + shift_s,
            velocity: note.velocity,
            speed_m_per_s: law.speed_m_per_s(note.velocity),
            release_m_per_s: note.release.map(|release| ReleaseLaw::USUAL.speed_m_per_s(release)),
        });
        let (mut feet, mut down) = (Vec::new(), false);
        for change in &piece.pedals {
            let time_s = change.time_s + shift_s;
            match change.controller {
                SUSTAIN => feet.push((time_s, PedalMove::Sustain(FULL_PEDAL_M * f64::from(change.value) / 127.0))),
                SOSTENUTO => {
                    let is_down = change.value >= 64;
                    if is_down != down {
                        feet.push((time_s, PedalMove::Sostenuto(is_down)));
                    }
                    down = is_down;
                }
                _ => {}
            }
        }
        let mut remarks = piece.remarks.lines();
        remarks.extend(soft_remark(piece));
        Score { law: *law, notes: notes.collect(), feet, shift_s, duration_s: piece.duration_s() + shift_s, remarks }
    }
}

/// Remark on the notes of a piece that lack the soft pedal.
fn soft_remark(piece: &Piece) -> Option<String> {
    let mut changes: Vec<_> = piece.pedals.iter().filter(|change| change.controller == SOFT).collect();
    // Of the changes before a passage the last one counts, if it left the pedal down.
    let before = changes.partition_point(|change| change.time_s <= 0.0);
    changes.drain(..before.saturating_sub(1));
    if before > 0 && changes[0].value == 0 {
        changes.remove(0);
    }
    let is_down = |value: u8| value >= 64;
    let was_up = |i: usize| i == 0 || !is_down(changes[i - 1].value);
    let times = (0..changes.len()).filter(|&i| is_down(changes[i].value) && was_up(i)).count();
    let under = |start_s: f64| {
        let before = changes.partition_point(|change| change.time_s <= start_s);
        before > 0 && is_down(changes[before - 1].value)
    };
    let notes = piece.notes.iter().filter(|note| under(note.start_s)).count();
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    (!changes.is_empty()).then(|| {
        let (changes, times) = (count(changes.len(), "change"), count(times, "time"));
        format!(
            "soft pedal ignored (controller 67: {changes}, down {times}, {} under it): the model's hammers do not shift",
            count(notes, "note")
        )
    })
}
