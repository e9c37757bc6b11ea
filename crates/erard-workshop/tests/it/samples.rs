//! Plausible grands around a file: complete spreads, one piano for all keys, regulated, the same every time.

use std::collections::BTreeMap;

use erard::instrument::{Certainty, Instrument, InstrumentFile, Spread, numbers_at};
use erard::keyboard::Keyboard;
use erard_workshop::measure::norms::lines;
use erard_workshop::measure::{MeasureError, measure_some};
use erard_workshop::sample::{SampleError, Sampled};
use erard_workshop::validate::Published;

const GRAND: &str = "concert-grand";

fn grand() -> &'static str {
    Instrument::builtin_text(GRAND).unwrap()
}

/// Every estimate of both concert grands has a spread, and the cloth, leather or wood that it shares.
#[test]
fn every_estimate_has_a_spread() {
    for name in [GRAND, "concert-grand-strings"] {
        let file = InstrumentFile::parse(Instrument::builtin_text(name).unwrap(), name).unwrap();
        let mut together: BTreeMap<&str, Vec<Spread>> = BTreeMap::new();
        let mut estimates = 0;
        for number in &file.provenance.numbers {
            let Some(citation) = &number.citation else { continue };
            if citation.certainty == Certainty::Estimate {
                estimates += 1;
                assert!(citation.spread.is_some(), "{name}: {}", number.key);
            }
            if let (Some(with), Some(spread)) = (&citation.together, citation.spread) {
                together.entry(with).or_default().push(spread);
            }
        }
        assert!(estimates > 150, "{name}: {estimates}");
        for shared in ["cloth: stiffness", "leather: stiffness", "wood of the key", "place of the knuckle"] {
            assert!(together.get(shared).is_some_and(|all| all.len() > 1), "{name}: {shared}");
        }
    }
}

/// A sample is another grand than its file's, within the reach of its spreads, and regulated; its number is in its
/// name. Numbers that are together move together.
#[test]
#[ignore = "ci: a sample is drawn, regulated and measured"]
fn a_sample_is_one_plausible_grand() {
    let sampled = Sampled::of_file(grand(), GRAND, &mut |_| true).unwrap();
    // One that is plausible at the first draw: others need several.
    let text = sampled.text(8, &mut |_| true).unwrap();
    let file = InstrumentFile::parse(&text, "sample").unwrap();
    assert!(file.instrument.name.ends_with(", sample 8"), "{}", file.instrument.name);
    let factor = |path: &str| {
        let of = |text: &str| numbers_at(text, path).unwrap()[0];
        of(&text) / of(grand())
    };
    // Woods: one factor for mass and inertia of three parts. Cloths of one batch share stiffness, except for the change
    // of their common exponent with thickness.
    let whippen = factor("body.whippen.mass_g");
    for path in ["body.whippen.inertia_kg_m2", "body.jack.mass_g", "body.lever.inertia_kg_m2"] {
        assert!((factor(path) / whippen - 1.0).abs() < 1e-9, "{path}");
    }
    assert!(whippen != 1.0 && (1.15_f64.powf(-2.1)..1.15_f64.powf(2.1)).contains(&whippen), "{whippen}");
    let knuckle = |zone: &str| numbers_at(&text, &format!("zone.{zone}.disc.center_mm")).unwrap();
    assert_eq!(knuckle("jack_knuckle"), knuckle("lever_knuckle"));

    let keys = [
        "dip_mm",
        "blow_mm",
        "let_off_mm",
        "drop_mm",
        "aftertouch_mm",
        "check_mm",
        "balance_weight_g",
        "friction_weight_g",
    ];
    let asked: Vec<_> = keys.iter().map(|key| lines().find(|line| line.key == *key).unwrap()).collect();
    let found = measure_some(&file.instrument, &asked, &mut |_| true).unwrap();
    for (line, value) in asked.iter().zip(found) {
        let [low, high] = line.range(40).map(Option::unwrap);
        // Weights by trial are within half a gram of those of the slow loop used for the adjustment.
        let margin = if line.unit == "g" { 0.5 } else { 1e-9 };
        assert!(((low - margin)..=(high + margin)).contains(&value.unwrap()), "{} {value:?}", line.key);
    }
}

/// Pianos are weighed to balance weights all over the usual range, 34 to 40 g, and their up-weights follow.
#[test]
#[ignore = "ci: four samples are drawn and weighed"]
fn samples_have_different_balance_weights() {
    let sampled = Sampled::of_file(grand(), GRAND, &mut |_| true).unwrap();
    let asked = ["balance_weight_g", "up_weight_g"].map(|key| lines().find(|line| line.key == key).unwrap());
    let weigh = |sample: u32| {
        let text = sampled.text(sample, &mut |_| true).unwrap();
        let file = InstrumentFile::parse(&text, "sample").unwrap();
        measure_some(&file.instrument, &asked, &mut |_| true)
            .unwrap()
            .into_iter()
            .map(Option::unwrap)
            .collect::<Vec<_>>()
    };
    let weighed: Vec<Vec<f64>> = (1..=4).map(weigh).collect();
    let span = |which: usize| {
        let all = || weighed.iter().map(|one| one[which]);
        all().fold(0.0, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    assert!(weighed.iter().all(|one| (33.5..40.5).contains(&one[0])), "{weighed:?}");
    assert!(span(0) > 2.0 && span(1) > 2.0, "{weighed:?}");
}

mod nightly {
    use super::*;

    /// A sample is the same every time. Its key belongs to that sample's piano: numbers neither graded nor adjusted are
    /// those of its base. (Of key 88 the second piano cannot be put right: that key is of the piano drawn next.)
    #[test]
    #[ignore = "nightly: three samples"]
    fn keys_of_a_sample_are_one_piano() {
        let keyboard = Keyboard::builtin(GRAND).unwrap();
        let sample =
            || Sampled::of_file(keyboard.base_text(), GRAND, &mut |_| true).unwrap().text(2, &mut |_| true).unwrap();
        let base = sample();
        assert_eq!(base, sample());
        let key = Sampled::of_key(&keyboard, 60, &mut |_| true).unwrap().text(2, &mut |_| true).unwrap();
        for path in [
            "body.whippen.mass_g",
            "zone.capstan_heel.felt.stiffness_N_per_m_r",
            "zone.check.friction_coefficient",
            "body.jack.friction_torque_N_m",
        ] {
            let [of_key, of_base] = [&key, &base].map(|text| numbers_at(text, path).unwrap());
            assert_eq!(of_key, of_base, "{path}");
            assert_ne!(of_base, numbers_at(grand(), path).unwrap(), "{path}");
        }
        let name = InstrumentFile::parse(&key, "key").unwrap().instrument.name.clone();
        assert!(name.contains("key 60") && name.ends_with("sample 2"), "{name}");
    }
}

/// Files without samples report why; an interruption ends the work.
#[test]
fn what_has_no_samples_says_so() {
    let rigid = Instrument::builtin_text("concert-grand-rigid").unwrap();
    let certain: String = rigid
        .lines()
        .map(|line| match line.find(", spread") {
            Some(at) => {
                let end = line[at + 1..].find([',', '}']).map_or(line.len(), |end| at + 1 + end);
                format!("{}{}\n", &line[..at], &line[end..])
            }
            None => format!("{line}\n"),
        })
        .collect();
    let sampled = Sampled::of_file(&certain, "certain", &mut |_| true).unwrap();
    let error = sampled.text(1, &mut |_| true).unwrap_err();
    assert!(matches!(error, SampleError::Certain { .. }) && error.to_string().contains("`spread`"), "{error}");
    let stopped = Sampled::of_file(grand(), GRAND, &mut |_| false).unwrap_err();
    assert!(matches!(stopped, SampleError::Measure(ref error) if MeasureError::is_interruption(error)), "{stopped}");
    let mut asked = 0;
    let sampled = Sampled::of_file(grand(), GRAND, &mut |_| true).unwrap();
    let stopped = sampled.text(1, &mut |_| {
        asked += 1;
        asked < 3
    });
    assert!(matches!(stopped, Err(SampleError::Interrupted)), "{stopped:?}");
}

/// A band decides if it is narrower than the range, or outside it.
#[test]
fn a_band_that_is_wider_than_what_was_published_cannot_tell() {
    let published = Published::builtin();
    let row = |name: &str| published.rows.iter().find(|row| row.name == name).unwrap();
    // 34 to 40 g.
    let two_ends = row("balance_weight");
    for (band, undecided) in [([33.0, 38.0], false), ([33.0, 41.0], true), ([20.0, 33.0], false), ([39.0, 60.0], true)]
    {
        assert_eq!(two_ends.is_undecided(band), undecided, "{band:?}");
    }
    // From 100 ms.
    let one_end = row("key_stroke_pp");
    for (band, undecided) in [([90.0, 110.0], true), ([101.0, 500.0], false), ([10.0, 99.0], false)] {
        assert_eq!(one_end.is_undecided(band), undecided, "{band:?}");
    }
}
