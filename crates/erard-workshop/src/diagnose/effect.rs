//! Effect of each cause on each reading: `effects.csv`, simulated on sound grands of the ensemble.
//!
//! Three cases of every cause, and the largest that is met where it is beyond them, are injected, one at a time, into
//! several drawn, regulated grands; a row holds the mean change of every feature, and the next its standard deviation
//! from grand to grand. `.ci/regenerate effects` rewrites the file.

use std::fmt::Write as _;
use std::sync::LazyLock;

use erard::Progress;
use erard::instrument::Instrument;

use super::bench::Bench;
use super::cause::{Cause, causes};
use super::entry::{Known, at};
use super::inject::inject_case;
use crate::cores;
use crate::measure::MeasureError;
use crate::worklist::{ReadingQuantity, Readings};

/// Features compared. Balance and friction weight are two independent combinations of D and U.
pub(super) const FEATURES: [&str; 18] = [
    "balance_weight_g",
    "friction_weight_g",
    "strike_weight_g",
    "front_weight_g",
    "strike_weight_ratio",
    "dip_mm",
    "blow_mm",
    "jack_position_mm",
    "lever_height_mm",
    "let_off_mm",
    "drop_mm",
    "aftertouch_mm",
    "check_mm",
    "repetition_spring_m_per_s",
    "damper_start_share",
    "key_alone_friction_g",
    "hammer_flange_g",
    "whippen_flange_g",
];
pub(super) const N: usize = FEATURES.len();
pub(super) const BALANCE: usize = 0;
pub(super) const FRICTION: usize = 1;

/// Values of all features; `None` if the event did not happen.
pub(super) type Features = [Option<f64>; N];

/// Check distance assumed for a hammer that is not caught, mm below the string, and its standard error. Estimates: a
/// check slightly too far does not catch at all, and a sound grand may be near that.
pub(super) const NOT_CAUGHT_MM: [f64; 2] = [24.0, 4.0];
/// Feature of the check distance.
pub(super) const CHECK: usize = at::CHECK;

/// Returns the cases of a cause in the table: light, plain, heavy, and the largest that is met if it is beyond these.
fn levels(cause: &Cause) -> impl Iterator<Item = f64> {
    (1..=if cause.beyond.is_some() { 4 } else { 3 }).map(f64::from)
}

/// Changes by a case of a cause.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Effect {
    /// Mean change; `None` if the event of the feature no longer happens.
    pub mean: Features,
    /// Standard deviation from grand to grand.
    pub spread: [f64; N],
}

/// The cases of every cause.
static EFFECTS: LazyLock<Vec<Vec<Effect>>> =
    LazyLock::new(|| parse(include_str!("effects.csv")).expect("the built-in effects read"));

pub(super) fn effects() -> &'static [Vec<Effect>] {
    &EFFECTS
}

fn parse(text: &str) -> Option<Vec<Vec<Effect>>> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next()?;
    (header.split(',').skip(3).eq(FEATURES)).then_some(())?;
    let mut rows = lines.map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers: Option<Vec<Option<f64>>> = cells
            .get(3..)?
            .iter()
            .map(|cell| if cell.is_empty() { Some(None) } else { cell.parse().ok().map(Some) })
            .collect();
        Some(([0, 1, 2].map(|at| cells[at].to_owned()), Features::try_from(numbers?).ok()?))
    });
    let mut all = Vec::new();
    for cause in causes() {
        let mut of_cause = Vec::new();
        for case in levels(cause) {
            let (start, mean) = rows.next()??;
            let (spread_start, spread) = rows.next()??;
            let is_of = |start: [String; 3], what: &str| start == [&cause.key, &*case.to_string(), what];
            (is_of(start, "mean") && is_of(spread_start, "spread")).then_some(())?;
            of_cause.push(Effect { mean, spread: spread.map(|x| x.unwrap_or(0.0)) });
        }
        all.push(of_cause);
    }
    rows.next().is_none().then_some(all)
}

/// Features of an action.
pub(super) fn features(readings: &Readings, bench: &Bench) -> Features {
    let mut features = of_known(&Known::of(readings, bench));
    features[at::RATIO] = readings.get(ReadingQuantity::Ratio);
    features
}

/// Known features of a key; D and U count only together.
pub(super) fn of_known(known: &Known) -> Features {
    std::array::from_fn(|feature| match feature {
        BALANCE => known.balance_g(),
        FRICTION => known.friction_g(),
        _ => known.at(feature),
    })
}

fn measured(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Features, MeasureError> {
    Ok(features(&Readings::of(instrument, progress)?, &Bench::of(instrument)?))
}

/// Simulates one row of the table: the changes by a case of a cause on some sound grands.
fn simulate(
    grands: &[(Instrument, Features)],
    cause: &Cause,
    case: f64,
    progress: &mut Progress<'_>,
) -> Result<Effect, MeasureError> {
    let mut changes: Vec<Features> = Vec::new();
    for (grand, before) in grands {
        let after = measured(&inject_case(grand, cause, case, false, progress)?, progress)?;
        changes.push(std::array::from_fn(|i| Some(after[i]? - before[i]?)));
    }
    let mut effect = Effect { mean: [None; N], spread: [0.0; N] };
    for i in 0..N {
        let values: Vec<f64> = changes.iter().filter_map(|change| change[i]).collect();
        // An event that happens on fewer than half of them counts as missing.
        if 2 * values.len() < changes.len() {
            continue;
        }
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0).max(1.0);
        effect.mean[i] = Some(mean);
        effect.spread[i] = libm::sqrt(variance);
    }
    Ok(effect)
}

/// Returns the file, simulated on these sound grands.
///
/// # Errors
/// See [`MeasureError`].
pub fn effects_csv(grands: &[Instrument], title: &str, progress: &mut Progress<'_>) -> Result<String, MeasureError> {
    let before = cores::map(grands, cores::count(), progress, |grand, progress| measured(grand, progress))?;
    let grands: Vec<(Instrument, Features)> = grands.iter().cloned().zip(before).collect();
    let jobs: Vec<(&Cause, f64)> =
        causes().iter().flat_map(|cause| levels(cause).map(move |case| (cause, case))).collect();
    let found = cores::map(&jobs, cores::count(), progress, |(cause, case), progress| {
        simulate(&grands, cause, *case, progress)
    })?;
    let mut text = format!("# {title}\ncause,case,what,{}\n", FEATURES.join(","));
    for ((cause, case), effect) in jobs.iter().zip(&found) {
        let cell = |value: Option<f64>| value.map_or(String::new(), |x| format!("{:.3}", x + 0.0));
        let row = |values: Features| values.map(cell).join(",");
        let _ = writeln!(text, "{},{case},mean,{}", cause.key, row(effect.mean));
        let _ = writeln!(text, "{},{case},spread,{}", cause.key, row(effect.spread.map(Some)));
    }
    Ok(text)
}

/// Simulates one case of one cause anew, counted from 0, and returns the largest difference from the file in units of a
/// reading's precision.
///
/// # Errors
/// See [`MeasureError`].
pub fn check_effects(
    grands: &[Instrument],
    cause: &Cause,
    case: usize,
    progress: &mut Progress<'_>,
) -> Result<f64, MeasureError> {
    let before = grands.iter().map(|grand| measured(grand, progress)).collect::<Result<Vec<_>, _>>()?;
    let grands: Vec<(Instrument, Features)> = grands.iter().cloned().zip(before).collect();
    let found = simulate(&grands, cause, case as f64 + 1.0, progress)?;
    let row = causes().iter().position(|own| own.key == cause.key).unwrap_or_default();
    let file = &effects()[row][case];
    let off = (0..N).map(|i| match (found.mean[i], file.mean[i]) {
        (Some(a), Some(b)) => (a - b).abs() / precision(i),
        (None, None) => 0.0,
        _ => f64::INFINITY,
    });
    Ok(off.fold(0.0, f64::max))
}

/// Precision of a feature's reading.
pub(super) fn precision(feature: usize) -> f64 {
    super::entry::entries()[feature].precision
}

const _: () = assert!(at::KEY_ALONE == 15 && at::HAMMER_FLANGE == 16 && at::WHIPPEN_FLANGE == 17 && at::RATIO == 4);

#[cfg(test)]
mod tests {
    use super::*;

    /// The amount of the largest case makes the change that is met, within a twentieth or a reading's precision, and
    /// friction comes before leverage before hammers and leads.
    #[test]
    fn the_table_is_whole() {
        for (cause, cases) in causes().iter().zip(effects()) {
            let Some(beyond) = &cause.beyond else { continue };
            let line = FEATURES.iter().position(|own| *own == beyond.line).unwrap();
            let made = cases[3].mean[line].unwrap();
            assert!((made - beyond.to).abs() < (0.05 * beyond.to.abs()).max(precision(line)), "{}: {made}", cause.key);
            assert_eq!(cause.set_again().is_some(), beyond.set_again.is_some(), "{}", cause.key);
        }
        let order = |start: &str| {
            let of = causes().iter().filter(|cause| cause.key.starts_with(start) || cause.key.ends_with(start));
            let places: Vec<u32> = of.map(|cause| cause.order).collect();
            assert!(places.windows(2).all(|pair| pair[0] == pair[1]) && !places.is_empty(), "{start}: {places:?}");
            places[0]
        };
        let steps = ["_friction", "dip_", "let_off_", "drop_", "spring_", "ratio_", "leads_"].map(order);
        assert!(steps.is_sorted() && order("_heavy") > order("ratio_"), "{steps:?}");
    }
}
