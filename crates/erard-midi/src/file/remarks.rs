//! What a file holds that a piano does not play as it is written.

use std::collections::BTreeMap;
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

/// The programs of General MIDI that are pianos, from 0.
const PIANOS: std::ops::Range<u8> = 0..8;

/// Parts of a file that were left out, merged or repaired, with their instants, s: the remarks of a passage are those
/// of its instants.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Remarks {
    /// Notes of the percussion channel.
    pub(super) percussion_s: Vec<f64>,
    /// Notes that are on no key.
    pub(super) beyond_s: Vec<f64>,
    /// Notes without a note-off.
    pub(super) endless_s: Vec<f64>,
    /// Notes that end as they begin.
    pub(super) empty_s: Vec<f64>,
    /// Notes that are part of another one's strike.
    pub(super) merged_s: Vec<f64>,
    /// Tempi of 0.
    pub(super) no_tempo_s: Vec<f64>,
    /// Notes by channel and program, both from 0; `None` before a program is chosen.
    pub(super) played: BTreeMap<(u8, Option<u8>), Vec<f64>>,
    /// First motion of a pedal by channel.
    pub(super) pedals: BTreeMap<u8, f64>,
    /// By track.
    pub(super) tracks: Vec<Loss>,
    /// Tracks that are announced and not there, and those that are.
    pub(super) missing: Option<[usize; 2]>,
}

/// What is lost of a track.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Loss {
    /// From 1.
    pub track: usize,
    /// Notes that were read of it.
    pub read: usize,
    /// Bytes that are no events.
    pub skipped: Vec<Skipped>,
    /// Where it breaks off, s.
    pub breaks_off_s: Option<f64>,
}

/// Bytes that are no events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Skipped {
    pub time_s: f64,
    pub at: usize,
    pub count: usize,
    pub notes: usize,
    pub untimed: bool,
}

impl Remarks {
    /// The remarks of a passage between two instants, s.
    #[must_use]
    pub fn within(&self, from_s: f64, to_s: f64) -> Self {
        let is_in = |time_s: &f64| (from_s..to_s).contains(time_s);
        let of = |all: &[f64]| all.iter().copied().filter(is_in).collect::<Vec<_>>();
        let played = self.played.iter().map(|(who, all)| (*who, of(all))).filter(|(_, all)| !all.is_empty());
        let tracks = self.tracks.iter().map(|loss| Loss {
            skipped: loss.skipped.iter().copied().filter(|one| is_in(&one.time_s)).collect(),
            breaks_off_s: loss.breaks_off_s.filter(is_in),
            ..*loss
        });
        Remarks {
            percussion_s: of(&self.percussion_s),
            beyond_s: of(&self.beyond_s),
            endless_s: of(&self.endless_s),
            empty_s: of(&self.empty_s),
            merged_s: of(&self.merged_s),
            no_tempo_s: of(&self.no_tempo_s),
            played: played.collect(),
            pedals: self.pedals.iter().filter(|(_, at_s)| **at_s < to_s).map(|(who, at_s)| (*who, *at_s)).collect(),
            tracks: tracks.collect(),
            missing: self.missing,
        }
    }

    /// Remarks, a sentence each.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let say = |all: &[f64], one: &str, many: &str| match all.len() {
            0 => None,
            1 => Some(format!("1 note {one}")),
            count => Some(format!("{count} notes {many}")),
        };
        let both = |all: &[f64], what: &str| say(all, what, what);
        let missing = self.missing.map(|[announced, found]| {
            format!("the header announces {announced} {}, and {found} are there", plural(announced, "track"))
        });
        let mut lines: Vec<String> = missing.into_iter().chain(self.tracks.iter().flat_map(Loss::lines)).collect();
        let no_tempo = (!self.no_tempo_s.is_empty()).then(|| {
            let count = self.no_tempo_s.len();
            format!("{count} {} of 0 us for a quarter note ignored", if count == 1 { "tempo" } else { "tempi" })
        });
        lines.extend(no_tempo);
        lines.extend(self.channels());
        lines.extend(both(&self.percussion_s, "of the percussion channel, 10, left out"));
        lines.extend(both(&self.beyond_s, "beyond the keyboard, A0 to C8, left out"));
        lines.extend(say(
            &self.merged_s,
            "at the instant of another of its key: one strike, as loud as the louder, held to the last note-off",
            "at the instant of another of their key: one strike, as loud as the loudest, held to the last note-off",
        ));
        lines.extend(both(&self.endless_s, "without an end: held until its key's next note, or the file's last event"));
        lines.extend(say(&self.empty_s, "that ends as it begins, left out", "that end as they begin, left out"));
        lines
    }

    /// Channels that are one piano, and programs that are none.
    fn channels(&self) -> Option<String> {
        let mut channels: Vec<u8> = self.played.keys().map(|(channel, _)| channel + 1).collect();
        channels.dedup();
        let mut programs: Vec<u8> = self.played.keys().filter_map(|(_, program)| *program).collect();
        programs.sort_unstable();
        programs.dedup();
        let is_piano = programs.iter().all(|program| PIANOS.contains(program));
        let programs = match is_piano {
            true => String::new(),
            false => format!(" ({})", listed("program", programs.iter().map(|program| program + 1))),
        };
        let pedals = match self.pedals.len() {
            0 => String::new(),
            1 if self.pedals.keys().eq(channels.iter().map(|channel| channel - 1).collect::<Vec<_>>().iter()) => {
                String::new()
            }
            _ => {
                let own = listed("channel", self.pedals.keys().map(|channel| channel + 1));
                format!("; a pedal is where the lowest of {own} has it")
            }
        };
        match channels.len() {
            0 => None,
            1 if is_piano => None,
            1 => Some(format!("channel {}{programs} is played on the piano", channels[0])),
            _ => Some(format!("{}{programs} are one piano here{pedals}", listed("channel", channels.into_iter()))),
        }
    }
}

impl Loss {
    fn lines(&self) -> Vec<String> {
        let Loss { track, read, skipped, breaks_off_s } = self;
        let lost: usize = skipped.iter().map(|one| one.notes).sum();
        let bytes: usize = skipped.iter().map(|one| one.count).sum();
        let skipped = skipped.first().map(|first| {
            let places = match skipped.len() {
                1 => String::new(),
                count => format!(" at {count} places, the first"),
            };
            let late = if skipped.iter().any(|one| one.untimed) { "; what follows may be early" } else { "" };
            let lost = if lost == 0 { "none".to_string() } else { lost.to_string() };
            let (count, is) = (plural(bytes, "byte"), if bytes == 1 { "is no event" } else { "are no events" });
            let all = read + self.skipped.iter().map(|one| one.notes).sum::<usize>();
            format!(
                "track {track}: {bytes} {count}{places} at byte {} {is}: {lost} of its {all} {} lost{late}",
                first.at + 1,
                plural(all, "note"),
            )
        });
        let off =
            breaks_off_s.map(|_| format!("track {track} breaks off: {read} {} read of it", plural(*read, "note")));
        skipped.into_iter().chain(off).collect()
    }
}

fn plural(count: usize, what: &str) -> String {
    format!("{what}{}", if count == 1 { "" } else { "s" })
}

/// Numbers in words: `program 49`, `channels 1, 2`.
fn listed(what: &str, numbers: impl Iterator<Item = u8>) -> String {
    let numbers: Vec<String> = numbers.map(|number| number.to_string()).collect();
    format!("{} {}", plural(numbers.len(), what), numbers.join(", "))
}
