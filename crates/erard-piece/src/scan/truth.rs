//! Ground truth: strikes of hammers, and the intervals in which they may fall.

use crate::note::Played;

/// A hammer met its string.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strike {
    /// The key, from 1.
    pub key: usize,
    /// The window that it belongs to, an index into [`Truth::windows`].
    pub window: usize,
    /// Instant of the impact, s.
    pub time_s: f64,
    /// The hammer's speed at the string, m/s.
    pub hammer_speed_m_per_s: f64,
    /// The hammer bounced: it met the string again although the key had not come up in between.
    pub again: bool,
    /// Instant at which the rising key set its damper down, s, and speed of its front, m/s; `None` if it was pressed
    /// again before.
    pub released: Option<[f64; 2]>,
}

/// An interval in which a key is played.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// The key, from 1.
    pub key: usize,
    /// Name of the case, or `piece`.
    pub case: &'static str,
    /// From this instant, s.
    pub from_s: f64,
    /// To this instant, s.
    pub to_s: f64,
}

/// All strikes, and the windows in which they fall. A window without a strike must contain no note.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Truth {
    /// By their beginning, then by key.
    pub windows: Vec<Window>,
    /// By their instant, then by key.
    pub strikes: Vec<Strike>,
}

impl Truth {
    /// The truth of a performance of this duration, s: a window per key.
    #[must_use]
    pub fn of_performance(notes: &[Played], duration_s: f64) -> Self {
        let mut keys: Vec<usize> = notes.iter().map(|note| note.wanted.key).collect();
        keys.sort_unstable();
        keys.dedup();
        let window = |key: &usize| Window { key: *key, case: "piece", from_s: 0.0, to_s: duration_s };
        let mut truth = Truth { windows: keys.iter().map(window).collect(), strikes: Vec::new() };
        for note in notes {
            let key = note.wanted.key;
            let Some(window) = keys.iter().position(|other| *other == key) else { continue };
            let strike = |&[time_s, hammer_speed_m_per_s]: &[f64; 2], again: bool, released| Strike {
                key,
                window,
                time_s,
                hammer_speed_m_per_s,
                again,
                released,
            };
            let first = note.impact.iter().map(|hit| strike(hit, false, note.released));
            truth.strikes.extend(first);
            // A note that failed at its instant and was struck later after all is no bounce.
            let later = note.more_impacts.iter().enumerate();
            truth.strikes.extend(later.map(|(i, hit)| strike(hit, i > 0 || note.impact.is_some(), None)));
        }
        truth.sort();
        truth
    }

    /// Adds another truth.
    pub fn add(&mut self, other: Truth) {
        let before = self.windows.len();
        self.windows.extend(other.windows);
        self.strikes.extend(other.strikes.into_iter().map(|one| Strike { window: one.window + before, ..one }));
        self.sort();
    }

    /// When the last window ends, s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.windows.iter().map(|window| window.to_s).fold(0.0, f64::max)
    }

    fn sort(&mut self) {
        self.strikes.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then(a.key.cmp(&b.key)));
    }
}
