//! Report on a stream.

use erard::level::LEVELS;
use serde::Serialize;

/// Counts of a stream, and its faults.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Report {
    /// Length of the stream by its own clock, s.
    pub duration_s: f64,
    /// Samples of keys and pedals that were taken.
    pub samples: u64,
    /// Samples that did not come after the last one of their key: left out.
    pub out_of_order: u64,
    /// Samples whose stamp is more than a second from those of their neighbours: left out.
    pub dropped_stamps: u64,
    /// Gaps of more than a second in the stream of all keys: held notes ended.
    pub stream_gaps: u64,
    /// Times that the sender's clock began anew: held notes ended.
    pub new_clocks: u64,
    /// Releases that nobody saw: the stream ended, stalled or had a gap.
    pub unseen_releases: u64,
    /// Why there is no note, where there is none.
    pub silence: Option<String>,
    /// Steps of all keys.
    pub steps: u64,
    /// Samples of keys that have no calibration: left out.
    pub uncalibrated: u64,
    /// Changes of contacts that were bounces.
    pub bounces: u64,
    /// Strokes to the lowest contact without a time: no contact above it had closed since the last note.
    pub untimed_strokes: u64,
    /// Strokes that came to the lowest contact too slowly to throw a hammer.
    pub slow_strokes: u64,
    /// Contacts that closed after the one below them.
    pub swapped_contacts: u64,
    /// Strokes whose contacts closed in less than half the time of the fastest press.
    pub fast_strokes: u64,
    /// Rises of sensed hammers that turned before their strings.
    pub lifts: u64,
    /// Note-ons and note-offs, cancelled ones among them.
    pub note_ons: u64,
    /// Note-offs.
    pub note_offs: u64,
    /// Keystrokes that were limited so that no hammer goes faster than 8 m/s.
    pub limited_strokes: u64,
    /// Steps, of 50 us, in them.
    pub limited_steps: u64,
    /// The fastest hammer, m/s.
    pub fastest_hammer_m_per_s: f64,
    /// Samples deeper than the key goes.
    pub deep_samples: u64,
    /// Gaps of 0.1 s or more without a sample of a key that was off its rest.
    pub gaps: u64,
    /// Number of times that all keys were released because the stream stalled.
    pub stalls: u64,
    /// Keys whose sensor stayed still between up and down for 10 s.
    pub stuck_keys: Vec<usize>,
    /// Keys whose sensor left the rest twenty times or more by less than 0.5 mm.
    pub noisy_keys: Vec<usize>,
    /// Steps in which a number was not finite: the key stayed where it was.
    pub non_finite_steps: u64,
    /// Samples a second of a key that moves, the median.
    pub rate_hz: Option<f64>,
    /// Bits over the key's travel: its smallest step.
    pub bits: Option<f64>,
    /// Expected error of the speed from these, counts of velocity.
    pub expected_error_counts: Option<f64>,
    /// The largest drift that was followed, a share of a sensor's range.
    pub largest_drift: f64,
    /// Number of drifts beyond the limit.
    pub drifts_beyond: u64,
    /// The longest time that a message and those before it take on a DIN cable, s.
    pub longest_on_a_cable_s: f64,
    /// Announced impacts that did not happen; their notes were ended at once.
    pub false_announcements: u64,
    /// Impacts that were announced, by level.
    pub ahead: Vec<Lead>,
}

/// Impacts of one level that were announced.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Lead {
    /// The level's name.
    pub level: &'static str,
    /// Notes, and those of them that were announced.
    pub notes: u64,
    /// Those of them that were announced.
    pub announced: u64,
    /// Time from the announcement to the impact, ms: shortest and median.
    pub shortest_ms: f64,
    /// Median, ms.
    pub median_ms: f64,
    /// Leads below 1 ms, which are useless.
    pub useless: bool,
    /// Largest error of the instant, ms.
    pub largest_error_ms: f64,
    /// Largest error of the speed, a share.
    pub largest_error_of_speed: f64,
    /// Those beyond 0.2 ms or 1 %.
    pub beyond: u64,
}

/// A useful lead, s.
const USEFUL_S: f64 = 1e-3;
/// Allowed errors of an announced impact: of its instant, s, and of its speed, as a share.
pub(crate) const ERRORS: [f64; 2] = [0.2e-3, 0.01];

/// The level of a hammer speed: the nearest in ratio.
fn level(speed_m_per_s: f64) -> usize {
    (1..LEVELS.len())
        .find(|&i| speed_m_per_s < (LEVELS[i - 1].1 * LEVELS[i].1).sqrt())
        .map_or(LEVELS.len() - 1, |i| i - 1)
}

/// Statistics of announcements.
#[derive(Debug, Clone, Default)]
pub(crate) struct Leads {
    notes: [u64; LEVELS.len()],
    kept: [Vec<[f64; 3]>; LEVELS.len()],
}

impl Leads {
    pub(crate) fn struck(&mut self, speed_m_per_s: f64) {
        self.notes[level(speed_m_per_s)] += 1;
    }

    pub(crate) fn kept(&mut self, told: [f64; 2], hit: [f64; 2], known_s: f64) {
        self.struck(hit[1]);
        self.kept[level(hit[1])].push([hit[0] - known_s, (told[0] - hit[0]).abs(), (told[1] / hit[1] - 1.0).abs()]);
    }

    pub(crate) fn table(&self) -> Vec<Lead> {
        let of = |i: usize| {
            let mut leads: Vec<f64> = self.kept[i].iter().map(|[lead, ..]| *lead).collect();
            leads.sort_by(f64::total_cmp);
            let largest = |k: usize| self.kept[i].iter().map(|all| all[k]).fold(0.0, f64::max);
            let median_s = leads.get(leads.len() / 2).copied().unwrap_or(0.0);
            Lead {
                level: LEVELS[i].0,
                notes: self.notes[i],
                announced: leads.len() as u64,
                shortest_ms: 1e3 * leads.first().copied().unwrap_or(0.0),
                median_ms: 1e3 * median_s,
                useless: median_s < USEFUL_S,
                largest_error_ms: 1e3 * largest(1),
                largest_error_of_speed: largest(2),
                beyond: self.kept[i].iter().filter(|all| all[1] > ERRORS[0] || all[2] > ERRORS[1]).count() as u64,
            }
        };
        (0..LEVELS.len()).filter(|i| self.notes[*i] > 0).map(of).collect()
    }
}
