//! How fast this machine is at it: a step, a press, many at once, a keyboard, the worst step, the kinematics.
//!
//! The benchmarks in `benches/` and the program `erard-bench` take their workloads from here, so that both time the
//! same. Times are medians over rounds in which everything that is compared has its turn, and come with their
//! quartiles; ratios are ratios of medians of one run.

mod bare;
pub mod callgrind;
mod grand;
mod keys;
pub mod latency;
mod load;
mod many;
mod sampling;
mod single;

pub use bare::OverBare;
pub use grand::{MF_N, STEP_S, STEPS, at_rest, described, grand, group, instrument, note, press};

pub use keys::{Ticks, keyboard};
pub use load::{Load, MAX_LANES};
pub use many::{LoadTimes, load_times};
pub use sampling::Times;
pub(crate) use sampling::{Timed, in_turn};

use erard::Progress;
use serde_json::{Value, json};

use latency::{of_group_steps, of_steps};

/// Duration of a measurement.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Rounds of everything that is timed in turn.
    pub rounds: usize,
    /// Steps of a note in one round.
    pub steps: u64,
    /// Groups of [`MAX_LANES`] grands for every core.
    pub groups_per_core: usize,
    /// Steps timed one by one; of groups as many as make the same number of single ones.
    pub single_steps: u64,
    /// Ticks of the keyboard timed one by one.
    pub ticks: usize,
}

impl Effort {
    /// Half a minute or so.
    pub const USUAL: Effort =
        Effort { rounds: 21, steps: STEPS, groups_per_core: 2, single_steps: 10_000_000, ticks: 200_000 };
    /// A second or so: it shows that everything works; its times are worth little.
    pub const QUICK: Effort =
        Effort { rounds: 3, steps: STEPS / 20, groups_per_core: 1, single_steps: 100_000, ticks: 2_000 };
}

/// The parts of [`measure`] in their order, and the share of the whole that is done when each ends, as it lasts on a
/// machine of two cores.
pub const PARTS: [(&str, f64); 6] = [
    ("step, press and pose", 0.2),
    ("many at once", 0.6),
    ("keyboard", 0.7),
    ("beside bare steps", 0.75),
    ("single steps", 0.9),
    ("group steps", 1.0),
];

/// Measures everything, as one flat JSON object: wall-clock times of this machine while it did whatever else it was
/// doing; `None` where `progress` ended the work.
pub fn measure(effort: &Effort, progress: &mut Progress<'_>) -> Option<Value> {
    let mut within = |part: usize, share: f64| {
        let from = part.checked_sub(1).map_or(0.0, |before| PARTS[before].1);
        progress(from + (PARTS[part].1 - from) * share)
    };
    let single = single::measure(effort, &mut |share| within(0, share))?;
    let many = many::measure(effort, &mut |share| within(1, share))?;
    let instruments = keyboard();
    let keyboard = keys::measure(&instruments, effort.ticks, &mut |share| within(2, share))?;
    let over_bare = bare::measure(&instruments, effort, &mut |share| within(3, share))?;
    let of_one = of_steps(effort.single_steps, &mut |share| within(4, share))?;
    let lanes = many::most();
    let group_steps = effort.single_steps / lanes.count() as u64;
    let of_group = of_group_steps(group_steps, lanes, &mut |share| within(5, share))?;
    let sets = json!({"instruction_sets": instruction_sets()});
    let parts = [sets, single, many, keyboard, over_bare, latency::report(&of_one, &of_group)];
    Some(parts.into_iter().filter_map(|part| part.as_object().cloned()).flatten().collect())
}

/// The vector instructions that the processor has.
pub fn instruction_sets() -> Vec<&'static str> {
    #[cfg(target_arch = "x86_64")]
    let all = [
        ("sse2", true),
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("fma", std::arch::is_x86_feature_detected!("fma")),
        ("avx512", std::arch::is_x86_feature_detected!("avx512f")),
    ];
    #[cfg(target_arch = "aarch64")]
    let all = [("neon", std::arch::is_aarch64_feature_detected!("neon"))];
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let all: [(&str, bool); 0] = [];
    all.into_iter().filter(|(_, found)| *found).map(|(name, _)| name).collect()
}
