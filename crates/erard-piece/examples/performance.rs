//! Writes a generated performance as a MIDI file: file, seconds and seed.
//!
//! `cargo run --release -p erard-piece --example performance -- performance.mid 600 1838`
//!
//! It is no music, but it asks of the actions what music does: melodies over broken chords, chords of both hands, runs,
//! repeated notes, trills and octaves, from pp to ff, with pedals that travel and the scatter of human hands. The
//! numbers are estimates, except where a source is given.

use std::collections::BTreeMap;

use erard_midi::file::{Note, PedalChange, Piece, Remarks, write};
use erard_midi::message::{SOFT, SOSTENUTO, SUSTAIN};
use erard_midi::{Resolution, Velocity, key_of_note};

/// Standard deviation of a beat's instant, of a finger within its chord, s, and of a velocity, counts.
const BEAT_S: f64 = 0.012;
const FINGER_S: f64 = 0.008;
const COUNTS: f64 = 4.0;
/// A melody comes before its chord by so much, s [Goebl, "Melody lead in piano performance", JASA 110, 2001: 30 ms].
const MELODY_LEAD_S: f64 = 0.025;
/// pp, p, mp, mf, f and ff, as velocities.
const LEVELS: [f64; 6] = [30.0, 44.0, 58.0, 72.0, 90.0, 106.0];
/// A pedal that travels is reported so often, s.
const REPORTED_S: f64 = 0.010;
/// Nobody plays a key twice within this time: one finger plays both notes, s.
const ONE_FINGER_S: f64 = 0.070;
/// A key is let go so long before it is played again, s, where its note is long enough.
const APART_S: f64 = 0.030;
/// Chords by the steps of a major scale on which they stand: I, vi, IV, V.
const CHORDS: [i32; 4] = [0, 5, 3, 4];

/// A pianist at work.
struct Pianist {
    random: fastrand::Rng,
    notes: Vec<Note>,
    pedals: Vec<PedalChange>,
    /// Where each pedal is, by controller.
    feet: BTreeMap<u8, u8>,
    /// The next beat, s, and how long it is.
    at_s: f64,
    beat_s: f64,
    /// The velocity around which is played.
    level: f64,
    /// The MIDI note of the tonic.
    tonic: i32,
}

/// A performance of about so many seconds. The same seed makes the same performance.
pub fn performance(seconds: f64, seed: u64) -> Piece {
    let mut pianist = Pianist {
        random: fastrand::Rng::with_seed(seed),
        notes: Vec::new(),
        pedals: Vec::new(),
        feet: BTreeMap::new(),
        at_s: 0.5,
        beat_s: 0.6,
        level: LEVELS[2],
        tonic: 48,
    };
    for section in 0.. {
        if pianist.at_s >= seconds {
            break;
        }
        pianist.begin();
        match section % 6 {
            0 => pianist.nocturne(),
            1 => pianist.chorale(),
            2 => pianist.runs(),
            3 => pianist.repetitions(),
            4 => pianist.octaves(),
            _ => pianist.trill(),
        }
        pianist.at_s += 0.5 * pianist.beat_s;
    }
    pianist.finish(seconds)
}

impl Pianist {
    /// A number of mean 0 and a standard deviation, no farther away than three of them.
    fn scatter(&mut self, deviation: f64) -> f64 {
        let sum: f64 = (0..12).map(|_| self.random.f64()).sum();
        deviation * (sum - 6.0).clamp(-3.0, 3.0)
    }

    /// A new section: key, tempo and level.
    fn begin(&mut self) {
        self.tonic = 43 + self.random.i32(0..12);
        self.beat_s = 60.0 / (66.0 + 40.0 * self.random.f64());
        self.level = LEVELS[self.random.usize(0..LEVELS.len())];
        let is_soft = self.level < LEVELS[1];
        self.pedal(SOFT, self.at_s - 0.2, if is_soft { 127 } else { 0 }, 0.15);
    }

    /// A note of the scale, from 0, as its MIDI note.
    fn degree(&self, step: i32) -> i32 {
        const MAJOR: [i32; 7] = [0, 2, 4, 5, 7, 9, 11];
        self.tonic + 12 * step.div_euclid(7) + MAJOR[step.rem_euclid(7) as usize]
    }

    /// Plays a note for so long, s, louder than the section's level by so many counts.
    fn note(&mut self, note: i32, at_s: f64, lasts_s: f64, louder: f64) {
        let Some(key) = u8::try_from(note).ok().and_then(key_of_note) else { return };
        let start_s = at_s + self.scatter(FINGER_S);
        let velocity = (self.level + louder + self.scatter(COUNTS)).clamp(16.0, 120.0);
        let velocity = Velocity::of_seven_bits(velocity as u8);
        self.notes.push(Note { key, start_s, end_s: start_s + lasts_s, velocity, release: None });
    }

    /// The next beat's instant, s, as a hand meets it.
    fn beat(&mut self) -> f64 {
        self.at_s + self.scatter(BEAT_S)
    }

    /// Moves a pedal to a value within a time, s, from an instant on, s.
    fn pedal(&mut self, controller: u8, from_s: f64, to: u8, within_s: f64) {
        let now = f64::from(self.feet.insert(controller, to).unwrap_or(0));
        if now == f64::from(to) {
            return;
        }
        let reports = (within_s / REPORTED_S).ceil().max(1.0) as u32;
        for report in 1..=reports {
            let share = f64::from(report) / f64::from(reports);
            let value = (now + share * (f64::from(to) - now)).round() as u8;
            self.pedals.push(PedalChange { time_s: (from_s + share * within_s).max(0.0), controller, value });
        }
    }

    /// Changes the sustain pedal after a beat: up when the new chord is down, then down as far as `depth`.
    fn change(&mut self, at_s: f64, up: u8, depth: u8) {
        let late_s = 0.04 + self.scatter(0.01);
        self.pedal(SUSTAIN, at_s + late_s, up, 0.06);
        let depth = (f64::from(depth) + self.scatter(5.0)).clamp(0.0, 127.0) as u8;
        self.pedal(SUSTAIN, at_s + late_s + 0.14, depth, 0.08);
    }

    /// A melody over broken chords; the pedal is changed with each bass, now and then it goes down by half only.
    fn nocturne(&mut self) {
        let mut step = 14 + self.random.i32(0..5);
        for bar in 0..8 {
            let chord = CHORDS[bar % 4];
            let swell = 8.0 * (std::f64::consts::PI * bar as f64 / 7.0).sin();
            let depth = if self.random.u32(0..3) == 0 { 70 } else { 120 };
            for beat in 0..4 {
                let at_s = self.beat();
                if beat == 0 {
                    self.note(self.degree(chord - 7), at_s, 0.9 * self.beat_s, swell - 4.0);
                    self.change(at_s, 0, depth);
                } else {
                    self.note(self.degree(chord + 4), at_s, 0.4 * self.beat_s, swell - 12.0);
                }
                for (off, third) in [(0.33, 2), (0.67, 4)] {
                    let within_s = at_s + off * self.beat_s;
                    self.note(self.degree(chord + third), within_s, 0.3 * self.beat_s, swell - 14.0);
                }
                if beat != 3 || self.random.bool() {
                    step = (step + self.random.i32(-2..=2)).clamp(12, 22);
                    self.note(self.degree(step), at_s - MELODY_LEAD_S, 0.95 * self.beat_s, swell + 6.0);
                }
                self.at_s += self.beat_s;
            }
        }
        self.pedal(SUSTAIN, self.at_s, 0, 0.1);
    }

    /// Chords of six notes in both hands. The pedal is changed by half; in the second part the sostenuto pedal holds a
    /// bass octave.
    fn chorale(&mut self) {
        for bar in 0..8_usize {
            let chord = CHORDS[bar % 4];
            let at_s = self.beat();
            let holds = bar == 4;
            if holds {
                self.pedal(SUSTAIN, at_s - 0.15, 0, 0.05);
                for low in [chord - 14, chord - 7] {
                    self.note(self.degree(low), at_s, 1.2 * self.beat_s, 0.0);
                }
                self.pedal(SOSTENUTO, at_s + 0.4 * self.beat_s, 127, 0.08);
                self.at_s += self.beat_s;
                continue;
            }
            for (voice, step) in
                [chord - 7, chord, chord + 7, chord + 9, chord + 11, chord + 14].into_iter().enumerate()
            {
                let (lead_s, louder) = if voice == 5 { (MELODY_LEAD_S, 6.0) } else { (0.0, -2.0) };
                self.note(self.degree(step), at_s - lead_s, 1.7 * self.beat_s, louder);
            }
            if bar < 4 {
                self.change(at_s, 35, 90);
            }
            self.at_s += 2.0 * self.beat_s;
        }
        self.pedal(SOSTENUTO, self.at_s, 0, 0.08);
        self.pedal(SUSTAIN, self.at_s, 0, 0.1);
    }

    /// Runs up and down three octaves, 7 to 12 notes a second, over a bass, with a little pedal.
    fn runs(&mut self) {
        for run in 0..4 {
            let rate = 7.0 + 5.0 * self.random.f64();
            let from_s = self.beat();
            self.note(self.degree(-7), from_s, 0.8, 0.0);
            self.change(from_s, 0, 50);
            for n in 0..22 {
                let step = if run % 2 == 0 { n } else { 21 - n };
                let swell = 0.4 * f64::from(step);
                self.note(self.degree(step), from_s + f64::from(n) / rate, 0.9 / rate, swell - 4.0);
            }
            self.at_s = from_s + 22.0 / rate;
        }
        self.pedal(SUSTAIN, self.at_s, 0, 0.1);
    }

    /// Repeated notes, 5 to 10 a second, over staccato chords, without pedal.
    fn repetitions(&mut self) {
        for bar in 0..6 {
            let rate = 5.0 + 5.0 * self.random.f64();
            let (chord, from_s) = (CHORDS[bar % 4], self.beat());
            for step in [chord - 7, chord, chord + 2] {
                self.note(self.degree(step), from_s, 0.12, -4.0);
            }
            let again = 8;
            let step = 14 + self.random.i32(0..7);
            for n in 0..again {
                let accent = if n % 4 == 0 { 4.0 } else { 0.0 };
                self.note(self.degree(step), from_s + f64::from(n) / rate, 0.5 / rate, accent);
            }
            self.at_s = from_s + f64::from(again) / rate;
        }
    }

    /// Octaves of both hands, 3 to 5 a second, louder than before; the pedal goes all the way down.
    fn octaves(&mut self) {
        self.level = (self.level + 14.0).min(108.0);
        for bar in 0..4 {
            let rate = 3.0 + 2.0 * self.random.f64();
            let chord = CHORDS[bar % 4];
            let from_s = self.beat();
            self.change(from_s, 0, 127);
            for n in 0..8 {
                let (at_s, step) = (from_s + f64::from(n) / rate, chord + [0, 2, 4, 5, 4, 2, 1, 0][n as usize]);
                for octave in [-7, 0, 7, 14] {
                    self.note(self.degree(step + octave), at_s, 0.6 / rate, 0.0);
                }
            }
            self.at_s = from_s + 8.0 / rate;
        }
        self.pedal(SUSTAIN, self.at_s, 0, 0.05);
    }

    /// A trill of 9 to 13 notes a second that swells, over a bass under the pedal.
    fn trill(&mut self) {
        let rate = 9.0 + 4.0 * self.random.f64();
        let from_s = self.beat();
        for low in [-7, 0, 4] {
            self.note(self.degree(low), from_s, 1.5, -4.0);
        }
        self.change(from_s, 0, 110);
        let lasts_s = 3.0;
        let count = (lasts_s * rate) as u32;
        for n in 0..count {
            let swell = 14.0 * (f64::from(n) / f64::from(count)) - 10.0;
            let step = 15 + (n % 2) as i32;
            self.note(self.degree(step), from_s + f64::from(n) / rate, 0.8 / rate, swell);
        }
        self.at_s = from_s + lasts_s + self.beat_s;
        self.pedal(SUSTAIN, self.at_s, 0, 0.1);
    }

    /// The piece, without what no hand plays: a key that is played again before it was let go, or twice at once.
    fn finish(mut self, seconds: f64) -> Piece {
        self.notes.sort_by(|a, b| a.start_s.total_cmp(&b.start_s).then(a.key.cmp(&b.key)));
        self.notes.retain(|note| note.start_s < seconds);
        let mut last_s = BTreeMap::new();
        self.notes.retain(|note| {
            let is_apart = last_s.get(&note.key).is_none_or(|last_s| note.start_s - last_s >= ONE_FINGER_S);
            if is_apart {
                last_s.insert(note.key, note.start_s);
            }
            is_apart
        });
        let mut next_s = BTreeMap::new();
        for note in self.notes.iter_mut().rev() {
            let next_s = next_s.insert(note.key, note.start_s).unwrap_or(f64::INFINITY);
            note.end_s = note.end_s.min((next_s - APART_S).max(0.5 * (note.start_s + next_s)));
        }
        self.pedals.retain(|change| change.time_s < seconds);
        self.pedals.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        Piece { notes: self.notes, pedals: self.pedals, remarks: Remarks::default() }
    }
}

#[allow(dead_code, reason = "the tests use this file as a module")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    const USAGE: &str = "expected FILE SECONDS SEED, such as performance.mid 600 1838";
    let given: Vec<String> = std::env::args().skip(1).collect();
    let [file, seconds, seed] = &given[..] else { return Err(USAGE.into()) };
    let seconds: f64 = seconds.parse().ok().filter(|s| (1.0..=36_000.0).contains(s)).ok_or(USAGE)?;
    let piece = performance(seconds, seed.parse().map_err(|_| USAGE)?);
    std::fs::write(file, write(&piece, Resolution::SevenBits)?)?;
    println!("{file}: {} notes, {} changes of pedals, {seconds} s", piece.notes.len(), piece.pedals.len());
    Ok(())
}
