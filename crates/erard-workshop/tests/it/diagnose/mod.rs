//! Diagnosis of one's own piano: reading, answer, and proof on pianos unknown to the program.

mod proof;

use erard::instrument::Instrument;
use erard_workshop::balance::Lead;
use erard_workshop::diagnose::{Diagnosis, Known, Standing, causes, check_effects, diagnose, inject};
use erard_workshop::measure::measure;
use erard_workshop::sample::Sampled;
use proof::{GRAND, KEY, sound_sample, sound_samples, tally};

fn known(pairs: &[(&str, f64)]) -> Known {
    let mut known = Known::default();
    pairs.iter().for_each(|(name, value)| known.set(name, Some(*value)));
    known
}

fn named(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.causes.iter().map(|ranked| ranked.cause.key.as_str()).collect()
}

fn standing<'a>(diagnosis: &'a Diagnosis, name: &str) -> &'a Standing {
    &diagnosis.lines.iter().find(|line| line.name == name).unwrap().standing
}

/// D 58, U 18, let-off 3.5, drop 0.2 mm: 20 g of friction and a correct balance weight of 38 g. It rubs somewhere, and
/// button or hammer line is low, which reduces the drop as well; no cause is a weight.
#[test]
fn friction_let_off_and_drop() {
    let found =
        diagnose(&known(&[("down_weight_g", 58.0), ("up_weight_g", 18.0), ("let_off_mm", 3.5), ("drop_mm", 0.2)]), 40);
    let value = |name: &str| found.lines.iter().find(|line| line.name == name).unwrap().value.unwrap();
    assert_eq!((value("balance_weight_g"), value("friction_weight_g")), (38.0, 20.0));
    assert_eq!(*standing(&found, "balance_weight_g"), Standing::Inside);
    assert_eq!(*standing(&found, "friction_weight_g"), Standing::Out);
    let causes = named(&found);
    assert!(["let_off_wide", "hammer_low"].contains(&causes[0]), "{causes:?}");
    assert!(causes.iter().any(|cause| cause.ends_with("friction")), "{causes:?}");
    let weights = ["hammer_heavy", "hammer_light", "leads_", "ratio_"];
    assert!(!causes.iter().any(|cause| weights.iter().any(|weight| cause.starts_with(weight))), "{causes:?}");
    // Weights show neither the place of friction nor a low hammer line: a further measurement is requested.
    let next = found.next.unwrap().name;
    assert!(!["down_weight_g", "let_off_mm", "drop_mm"].contains(&next), "{next}");
    assert!(found.geometry.ratio.is_none() && found.geometry.inertia_kg.is_none());
}

/// The requested test decides, whatever its result.
#[test]
fn the_quick_test_tells_places_of_friction_apart() {
    let weights = [("down_weight_g", 58.0), ("up_weight_g", 18.0)];
    let with = |name: &'static str, value: f64| {
        let found = diagnose(&known(&[&weights[..], &[(name, value)]].concat()), 40);
        (found.causes[0].cause.key.clone(), found.causes[0].probability)
    };
    for (name, value, cause) in [
        ("key_alone_friction_g", 12.5, "key_friction"),
        ("hammer_flange_g", 13.0, "hammer_friction"),
        ("hammer_swings", 1.0, "hammer_friction"),
        ("whippen_flange_g", 45.0, "whippen_friction"),
    ] {
        let (first, probability) = with(name, value);
        assert!(first == cause && probability > 0.8, "{name} {value}: {first} {probability}");
    }
    // A dry knuckle does not show in the weights: let-off, drop and aftertouch become smaller together.
    let knuckle = [("let_off_mm", 0.8), ("drop_mm", 0.1), ("aftertouch_mm", 0.5), ("dip_mm", 10.0), ("blow_mm", 46.0)];
    assert_eq!(named(&diagnose(&known(&knuckle), 40))[0], "knuckle_friction");
}

/// A reading outside by less than its error needs no work; a missing one is not judged; a sharp's dip is not compared
/// with a natural's.
#[test]
fn nothing_is_made_of_nothing() {
    let near = diagnose(&known(&[("let_off_mm", 2.2), ("dip_mm", 9.4)]), 40);
    assert!(!near.is_work() && near.causes.is_empty() && *standing(&near, "let_off_mm") == Standing::Doubtful);
    let sharp = diagnose(&known(&[("dip_mm", 8.5), ("down_weight_g", 50.0)]), 41);
    assert!(!sharp.is_work() && matches!(standing(&sharp, "dip_mm"), Standing::NotJudged(_)));
    assert!(diagnose(&known(&[("dip_mm", 8.5)]), 40).is_work());
    // A hammer that is not caught is a reading, too.
    let mut open = Known::default();
    open.is_not_caught = true;
    assert_eq!(named(&diagnose(&open, 40))[0], "check_far");
}

/// The sheet's inertia is inside the band from weights alone, and known places of the leads narrow the band.
#[test]
#[ignore = "ci: two sheets"]
fn the_band_of_inertia_holds_the_sheet_s() {
    for name in [GRAND, "heavy-touch"] {
        let instrument = Instrument::builtin(name).unwrap();
        let sheet = measure(&instrument, &mut |_| true).unwrap();
        let mut known = Known::measured(&instrument, &mut |_| true).unwrap();
        let band = diagnose(&known, KEY).geometry.inertia_kg.unwrap();
        assert!((band.low..=band.high).contains(&sheet.effective_inertia_kg), "{name} {band:?}");
        if name == GRAND {
            known.leads = vec![Lead { mass_g: 14.0, at_mm: 164.0 }, Lead { mass_g: 14.0, at_mm: 146.0 }];
            let narrow = diagnose(&known, KEY).geometry.inertia_kg.unwrap();
            assert!((narrow.low..=narrow.high).contains(&sheet.effective_inertia_kg), "{narrow:?}");
            assert!(narrow.high - narrow.low < band.high - band.low, "{band:?} {narrow:?}");
        }
    }
}

/// The heavy action of the book: its leverage was made wrong, and explains the other readings.
#[test]
fn heavy_touch_is_seen_through() {
    let heavy = Instrument::builtin("heavy-touch").unwrap();
    let found = diagnose(&Known::measured(&heavy, &mut |_| true).unwrap(), KEY);
    let causes = named(&found);
    assert_eq!(causes[0], "ratio_high", "{:?}", found.causes);
    let ratio = found.geometry.ratio.unwrap();
    // The sheet's R, which contains friction.
    assert!((ratio.low..=ratio.high).contains(&7.0), "{ratio:?}");
}

/// A let-off that was made too wide is the first cause that is named on that many unknown pianos. Undoing it, by the
/// amount that was named, leaves no reading out of range that was not out before; on the first of them none.
fn undoing_cures(pianos: usize) {
    let sampled = Sampled::of_file(Instrument::builtin_text(GRAND).unwrap(), GRAND, &mut |_| true).unwrap();
    let cause = causes().iter().find(|cause| cause.key == "let_off_wide").unwrap();
    let asked = |grand: &Instrument| diagnose(&Known::measured(grand, &mut |_| true).unwrap(), KEY);
    let out = |found: &Diagnosis| -> Vec<&str> {
        found.lines.iter().filter(|line| line.standing == Standing::Out).map(|line| line.name).collect()
    };
    let healthy: Vec<_> = (6001..6100).filter_map(|number| sound_sample(&sampled, number)).take(pianos).collect();
    assert_eq!(healthy.len(), pianos);
    for (place, healthy) in healthy.iter().enumerate() {
        let ill = inject(healthy, cause, -0.3e-3, false, &mut |_| true).unwrap();
        let found = asked(&ill);
        assert_eq!(found.causes[0].cause.key, "let_off_wide", "{place}");
        let amount = erard_workshop::diagnose::injected_amount(found.causes[0].cause, found.causes[0].case);
        let cured = asked(&inject(&ill, found.causes[0].cause, amount, true, &mut |_| true).unwrap());
        println!("{place}: undone by {} mm of 0.3; still out: {:?}", -1e3 * amount, out(&cured));
        assert_eq!(out(&cured), out(&asked(healthy)), "{place}");
        assert!(place > 0 || !cured.is_work());
    }
}

#[test]
#[ignore = "ci: a drawn grand"]
fn undoing_what_is_named_cures() {
    undoing_cures(1);
}

mod nightly {
    use super::{GRAND, Instrument, Sampled, causes, check_effects};

    #[test]
    #[ignore = "nightly: eight drawn grands"]
    fn undoing_what_is_named_cures_eight_grands() {
        super::undoing_cures(8);
    }

    /// The file's numbers are those of the simulation: one case of one cause on the grands of the file.
    #[test]
    #[ignore = "nightly: five drawn grands, measured twice"]
    fn effects_are_what_is_simulated() {
        let sampled = Sampled::of_file(Instrument::builtin_text(GRAND).unwrap(), GRAND, &mut |_| true).unwrap();
        let text = include_str!("../../../src/diagnose/effects.csv");
        let numbers = text.lines().next().unwrap().split_whitespace().filter_map(|word| word.parse::<u32>().ok());
        let grands: Vec<Instrument> =
            numbers.map(|number| super::sound_sample(&sampled, number).expect("it is sound")).collect();
        assert!(grands.len() > 2);
        let cause = causes().iter().find(|cause| cause.key == "let_off_wide").unwrap();
        let off = check_effects(&grands, cause, 1, &mut |_| true).unwrap();
        // The file has three decimals.
        assert!(off < 0.02, "{off}");
    }

    /// 60 pianos of one fault each, on copies of 8 drawn grands, and 20 readings of the sound grands.
    #[test]
    #[ignore = "nightly: 8 drawn grands, 60 planted faults"]
    fn sixty_planted_faults_are_found() {
        let tally = super::tally(&super::sound_samples(8, 5001), 60, 20, 0);
        println!("{}", tally.report());
        assert_eq!((tally.pianos(), tally.healthy), (60, [20; 2]), "{}", tally.report());
        assert!(tally.first(2) >= 50, "{}", tally.report());
    }
}
