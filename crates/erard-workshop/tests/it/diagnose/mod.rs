//! Diagnosis of one's own piano: reading, answer, and proof on pianos unknown to the program.

mod planted;
mod proof;

use erard::instrument::Instrument;
use erard_workshop::balance::Lead;
use erard_workshop::diagnose::{Diagnosis, Judged, Known, Standing, causes, check_effects, diagnose, inject};
use erard_workshop::measure::measure;
use erard_workshop::sample::Sampled;
use erard_workshop::validate::{CaseUse, CaseVerdict, Cases};
use planted::Reading;
use proof::{GRAND, KEY, ranked, sound_sample, sound_samples, tally};

fn known(pairs: &[(&str, f64)]) -> Known {
    let mut known = Known::default();
    pairs.iter().for_each(|(name, value)| known.set(name, Some(*value)));
    known
}

fn named(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.causes.iter().map(|ranked| ranked.cause.key.as_str()).collect()
}

/// Causes that the readings leave open.
fn open(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.undecided.iter().map(|ranked| ranked.cause.key.as_str()).collect()
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
    let causes = [named(&found), open(&found)].concat();
    assert!(["let_off_wide", "hammer_low"].contains(&causes[0]), "{causes:?}");
    // Where it rubs is left open: two places at least.
    assert!(open(&found).iter().filter(|cause| cause.ends_with("friction")).count() >= 2, "{causes:?}");
    let to_do = found.to_do();
    assert!(
        found.weigh_again && to_do.iter().any(|line| line.starts_with("Ease friction and weigh again")),
        "{to_do:?}"
    );
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
        let first = ranked(&found)[0];
        (first.cause.key.clone(), first.probability)
    };
    // One swing may be 6 to 20 g at 23 mm: it says less than a gauge.
    for (name, value, cause, least) in [
        ("key_alone_friction_g", 12.5, "key_friction", 0.8),
        ("hammer_flange_g", 13.0, "hammer_friction", 0.8),
        ("hammer_swings", 1.0, "hammer_friction", 0.8),
        ("whippen_flange_g", 45.0, "whippen_friction", 0.8),
    ] {
        let (first, probability) = with(name, value);
        assert!(first == cause && probability > least, "{name} {value}: {first} {probability}");
    }
    // A dry knuckle does not show in the weights: let-off, drop and aftertouch become smaller together.
    let knuckle = [("let_off_mm", 0.8), ("drop_mm", 0.1), ("aftertouch_mm", 0.5), ("dip_mm", 10.0), ("blow_mm", 46.0)];
    assert_eq!(ranked(&diagnose(&known(&knuckle), 40))[0].cause.key, "knuckle_friction");
}

/// A reading outside by less than its error needs no work; a missing one is not judged; a sharp's dip is not compared
/// with a natural's.
#[test]
fn nothing_is_made_of_nothing() {
    let near = diagnose(&known(&[("let_off_mm", 2.7), ("dip_mm", 9.4)]), 40);
    assert!(!near.is_work() && near.causes.is_empty() && *standing(&near, "let_off_mm") == Standing::Doubtful);
    // What it would be if it read the same is said, and no work.
    assert_eq!(open(&diagnose(&known(&[("dip_mm", 9.4)]), 40))[0], "dip_shallow");
    assert!(near.verdict().contains("If they read the same, it may be: ") && near.to_do().is_empty());
    let sharp = diagnose(&known(&[("dip_mm", 8.5), ("down_weight_g", 50.0)]), 41);
    assert!(!sharp.is_work() && matches!(standing(&sharp, "dip_mm"), Standing::NotJudged(_)));
    assert!(diagnose(&known(&[("dip_mm", 8.5)]), 40).is_work());
    // A hammer that is not caught is a reading, too.
    let mut open = Known::default();
    open.is_not_caught = true;
    assert_eq!(ranked(&diagnose(&open, 40))[0].cause.key, "check_far");
}

/// Published pianos that were looked at while the ranking was changed: none gets harmful work, and these are missed.
#[test]
fn published_pianos_that_choose() {
    let mut missed = Vec::new();
    for case in Cases::builtin().cases.iter().filter(|case| case.used == CaseUse::Choose) {
        for result in case.run().unwrap() {
            assert_ne!(result.verdict, CaseVerdict::Harmful, "{} {result:?}", case.name);
            if result.verdict == CaseVerdict::Missed {
                missed.push(format!("{} {}", case.name, result.key));
            }
        }
    }
    assert_eq!(missed, MISSED, "a case that is met now leaves the list");
}

/// Cases that choose and are missed. Of two heavier things the head is inside its range at 10.4 g; a hammer that is not
/// caught can be a far check, a shallow dip or a tail, and only the last two are left open; a heavy hammer and a ratio
/// that do not go together need 42.7 g of front weight, which is over the ceiling of 41.3 g by less than readings err.
const MISSED: [&str; 3] = ["planted-capstan-head-20 40", "tails 12", "heavy-hammers-at-5-9 1"];

/// With a ratio that was read, the weight that was not follows by the equation of balance, with KR WW = 9.5 g. By hand:
/// 9.5 + 6 x 10 - 20 = 49.5 g of balance weight, 9.5 + 6 x 10.4 - 35 = 36.9 g of front weight, and
/// (37 + 20 - 9.5) / 5 = 9.5 g of strike weight. What was read is in its range; the first two that follow are not.
#[test]
fn weights_that_follow_from_the_ratio_are_judged() {
    let asked = |readings: &[(&str, f64)]| diagnose(&known(readings), 40);
    let line = |found: &Diagnosis, name: &str| {
        let of = |line: &&Judged| line.name == name && line.label.contains("equation");
        found.lines.iter().find(of).map(|line| (line.value.unwrap(), line.standing.clone())).unwrap()
    };
    let heavy = asked(&[("strike_weight_g", 10.0), ("strike_weight_ratio", 6.0), ("front_weight_g", 20.0)]);
    let (value, standing) = line(&heavy, "balance_weight_g");
    assert!((value - 49.5).abs() < 0.05 && standing == Standing::Out, "{value} {standing:?}");
    assert!(named(&heavy).iter().all(|cause| *cause == "leads_few"), "{:?}", named(&heavy));
    let weights = [("down_weight_g", 45.0), ("up_weight_g", 25.0), ("strike_weight_ratio", 6.0)];
    let leaded = asked(&[&weights[..], &[("strike_weight_g", 10.4)]].concat());
    let (value, standing) = line(&leaded, "front_weight_g");
    assert!((value - 36.9).abs() < 0.05 && standing == Standing::Out, "{value} {standing:?}");
    let weights = [("down_weight_g", 47.0), ("up_weight_g", 27.0), ("strike_weight_ratio", 5.0)];
    let sound = asked(&[&weights[..], &[("front_weight_g", 20.0)]].concat());
    assert!((line(&sound, "strike_weight_g").0 - 9.5).abs() < 0.05 && !sound.is_work(), "{sound:?}");
}

/// A hammer and a leverage that are each in their ranges within a reading's error may need more lead than a key should
/// carry: 9 + 6.1 x 10.6 - 40 = 33.7 g of front weight, for a ceiling of 30. Either may be the cause: these readings do
/// not tell which, and say so.
#[test]
fn hammer_and_leverage_are_judged_together() {
    let pair = [("strike_weight_g", 10.6), ("strike_weight_ratio", 6.1)];
    let whippen = [("whippen_weight_g", 18.0), ("key_ratio", 0.5)];
    let found = diagnose(&known(&[&pair[..], &whippen[..]].concat()), 40);
    let needed = found.lines.iter().find(|line| line.name == "front_weight_g").unwrap();
    assert!((needed.value.unwrap() - 33.66).abs() < 0.05 && needed.standing == Standing::Out, "{needed:?}");
    assert!(named(&found).is_empty(), "{:?}", named(&found));
    let open = open(&found);
    assert!(open.contains(&"hammer_heavy") && open.contains(&"ratio_high"), "{open:?}");
    assert!(found.open_question().unwrap().starts_with("These readings decide nothing among"));
    // At the ends of both ranges it is 9.5 + 6.06 x 10.5 - 40 = 33.1 g, which these readings do not know well enough.
    let found = diagnose(&known(&[("strike_weight_g", 10.5), ("strike_weight_ratio", 6.06)]), 40);
    assert!(!found.is_work() && found.is_doubtful(), "{}", found.verdict());
    assert!(diagnose(&known(&[("strike_weight_g", 9.5), ("strike_weight_ratio", 5.5)]), 40).undecided.is_empty());
}

/// Nobody is sent to a screw, a hammer or leads whose own reading was not taken: a balance weight of 45 g names none,
/// and a short blow names no lever height, which moves it on some grands.
#[test]
fn what_was_not_read_is_not_changed() {
    let weights = [("down_weight_g", 54.0), ("up_weight_g", 36.0)];
    let found = diagnose(&known(&weights), 40);
    assert!(found.is_work() && named(&found).is_empty(), "{:?}", named(&found));
    assert!(["hammer_heavy", "leads_few", "ratio_high"].iter().all(|cause| open(&found).contains(cause)));
    let short = diagnose(&known(&[("dip_mm", 10.0), ("blow_mm", 42.5), ("aftertouch_mm", 1.0)]), 40);
    assert!(short.is_work() && named(&short).is_empty() && open(&short)[0] == "lever_high", "{:?}", short.causes);
    // Front weight, hammer and the ratio that follows are right but for the leads.
    let found = diagnose(&known(&[&weights[..], &[("front_weight_g", 17.0), ("strike_weight_g", 9.5)]].concat()), 40);
    assert_eq!(named(&found), ["leads_few"], "{:?}", found.causes);
}

/// A low leverage and missing leads: either cure alone takes the balance weight farther out or leaves the ratio, and
/// both together bring all of it in. Leverage comes first.
#[test]
fn cures_that_need_each_other_are_judged_together() {
    let weights = [("down_weight_g", 58.0), ("up_weight_g", 38.0), ("front_weight_g", 5.0), ("strike_weight_g", 9.5)];
    let found = diagnose(&known(&weights), 40);
    assert_eq!(named(&found), ["ratio_low"], "{:?}", found.withheld);
    assert_eq!(found.withheld.iter().map(|ranked| &*ranked.cause.key).collect::<Vec<_>>(), ["leads_few"]);
}

/// A reading proves that its event took place: a check that catches nothing is no cause of a brisk rise from it.
#[test]
fn a_reading_speaks_against_what_prevents_it() {
    let found = diagnose(&known(&[("repetition_spring_m_per_s", 0.6)]), 40);
    assert_eq!(named(&found), ["spring_strong"]);
    assert!(found.causes[0].probability > 0.7 && !open(&found).contains(&"check_far"), "{found:?}");
}

/// A down-weight alone decides nothing: no cause is named, friction and weights stay open, and the up-weight is asked
/// for.
#[test]
fn a_weight_alone_decides_nothing() {
    let found = diagnose(&known(&[("down_weight_g", 70.0)]), 40);
    assert!(found.is_work() && found.causes.is_empty(), "{:?}", named(&found));
    let open = open(&found);
    assert!(open.iter().any(|cause| cause.ends_with("friction")) && open.contains(&"hammer_heavy"), "{open:?}");
    assert!(found.open_question().unwrap().starts_with("These readings decide nothing among"));
    assert_eq!(found.next.as_ref().unwrap().name, "down_weight_g");
}

/// Two causes at most are named, friction before leverage before hammers and leads.
#[test]
fn causes_come_in_the_trades_order() {
    let weights = [("down_weight_g", 88.0), ("up_weight_g", 36.0), ("strike_weight_g", 9.0), ("front_weight_g", 20.0)];
    let rubbing = [("key_alone_friction_g", 19.0), ("hammer_flange_g", 4.0)];
    let found = diagnose(&known(&[&weights[..], &rubbing[..]].concat()), 40);
    assert_eq!(named(&found), ["key_friction", "ratio_high"], "{:?}", found.causes);
    let to_do = found.to_do();
    let of = |word: &str| to_do.iter().position(|line| line.contains(word)).unwrap();
    assert!(of("balance hole") < of("capstan line") && to_do[of("capstan line")].contains("Weigh again"), "{to_do:?}");
}

/// Swings show one flange and nothing else: two and fewer name it, also in the treble, three may be four, and four are
/// usual.
#[test]
fn swings_name_the_flange() {
    let asked = |key: usize, swings: f64| diagnose(&known(&[("hammer_swings", swings)]), key);
    for key in [20, 60, 72] {
        assert_eq!(named(&asked(key, 1.0)), ["hammer_friction"], "{key}");
        assert!(!asked(key, 3.0).is_work() && !asked(key, 4.0).is_doubtful(), "{key}");
    }
    assert_eq!(named(&asked(60, 2.0)), ["hammer_friction"]);
}

/// A let-off of 3.2 mm is set by its button, although a hammer line so low that the key ends before let-off would make
/// it, too: the blow was not taken. A long blow that was taken decides for the hammer line.
#[test]
fn own_readings_come_first() {
    let asked = |readings: &[(&str, f64)]| diagnose(&known(readings), 40);
    assert_eq!(named(&asked(&[("let_off_mm", 3.2)])), ["let_off_wide"]);
    assert_eq!(named(&asked(&[("let_off_mm", 3.2), ("blow_mm", 46.0)])), ["let_off_wide"]);
    assert_eq!(named(&asked(&[("let_off_mm", 3.2), ("blow_mm", 51.5)])), ["hammer_low"]);
}

/// A cure that takes other readings farther out is withheld, with the reading: a shallow dip with a long aftertouch is
/// what a high leverage was regulated to, and paper taken out lengthens the aftertouch.
#[test]
fn a_cure_that_makes_it_worse_is_withheld() {
    let found =
        diagnose(&known(&[("dip_mm", 9.0), ("blow_mm", 46.0), ("aftertouch_mm", 2.6), ("let_off_mm", 1.5)]), 40);
    assert_eq!(named(&found), ["ratio_high"], "{:?} {:?}", found.causes, found.withheld);
    assert!(found.withheld.iter().any(|ranked| ranked.cause.key == "dip_shallow"), "{:?}", found.withheld);
    assert!(found.to_do().iter().any(|line| line.starts_with("Not yet for") && line.contains("aftertouch")));
}

/// A deep dip or a short blow that makes up for a low leverage, and a shallow dip for a high one: leverage comes first,
/// and dip and blow stay as they are until then.
#[test]
fn what_makes_up_for_a_leverage_waits() {
    for (ratio, line, value, cause, waits) in
        [(4.3, "dip_mm", 12.3, "ratio_low", "dip_deep"), (7.2, "dip_mm", 8.2, "ratio_high", "dip_shallow")]
    {
        let found = diagnose(&known(&[("strike_weight_ratio", ratio), (line, value)]), 40);
        assert_eq!(named(&found), [cause], "{:?}", found.causes);
        let withheld: Vec<&str> = found.withheld.iter().map(|ranked| &*ranked.cause.key).collect();
        assert_eq!(withheld, [waits]);
        assert!(found.to_do().iter().any(|line| line.starts_with("Not yet for") && line.contains("leverage")));
    }
    // A capstan that was turned up makes up for the leverage, too, and waits for it: no screw is named.
    let found = diagnose(&known(&[("strike_weight_ratio", 4.3), ("blow_mm", 41.0)]), 40);
    assert_eq!(named(&found), ["ratio_low"]);
    let waits = found.withheld.iter().any(|ranked| ranked.cause.key == "hammer_high");
    assert!(waits || open(&found).contains(&"hammer_high"), "{:?}", found.undecided);
}

/// A cause without a model is a sentence with a test: many swings are a sign of loose pinning alone.
#[test]
fn looks_are_sentences() {
    let found = diagnose(&known(&[("hammer_swings", 12.0)]), 40);
    assert!(found.is_look && found.causes.is_empty() && found.looks[0].key == "loose_pinning", "{found:?}");
    assert!(found.to_do()[0].contains("sideways"), "{:?}", found.to_do());
    // No further reading tells more, and one that is doubtful says what it may be.
    assert!(found.next.is_none());
    let near = diagnose(&known(&[("hammer_swings", 10.0)]), 40);
    assert!(!near.is_work() && near.verdict().contains("it may be: loose pinning"), "{}", near.verdict());
    // A reading that no simulated cause changes has its looks, and asks for nothing.
    let lost = diagnose(&known(&[("lost_motion_mm", 1.0)]), 40);
    assert!(lost.is_work() && lost.verdict().contains("look for: compressed cloth"), "{}", lost.verdict());
    assert!(lost.next.is_none() && lost.to_do()[0].starts_with("Look for compressed cloth"), "{:?}", lost.to_do());
    let damp = diagnose(&known(&[("down_weight_g", 62.0), ("up_weight_g", 16.0)]), 40);
    assert!(!damp.is_look && damp.looks.iter().any(|look| look.key == "humidity"), "{:?}", damp.looks);
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
    assert!(named(&found).contains(&"ratio_high"), "{:?}", found.causes);
    let ratio = found.geometry.ratio.unwrap();
    // The sheet's R, which contains friction.
    assert!((ratio.low..=ratio.high).contains(&7.0), "{ratio:?}");
}

/// On three of four unknown pianos a let-off that was made too wide by 0.3 mm is the first cause that is named, and on
/// none another. Undoing it, by the amount that was named, leaves no reading out of range that was not out before; on
/// the first of them none.
fn undoing_cures(pianos: usize) {
    let sampled = Sampled::of_file(Instrument::builtin_text(GRAND).unwrap(), GRAND, &mut |_| true).unwrap();
    let cause = causes().iter().find(|cause| cause.key == "let_off_wide").unwrap();
    let asked = |grand: &Instrument| diagnose(&Known::measured(grand, &mut |_| true).unwrap(), KEY);
    let out = |found: &Diagnosis| -> Vec<&str> {
        found.lines.iter().filter(|line| line.standing == Standing::Out).map(|line| line.name).collect()
    };
    let healthy: Vec<_> = (6001..6100).filter_map(|number| sound_sample(&sampled, number)).take(pianos).collect();
    assert_eq!(healthy.len(), pianos);
    let mut shown = 0;
    for (place, healthy) in healthy.iter().enumerate() {
        let ill = inject(healthy, cause, -0.3e-3, false, &mut |_| true).unwrap();
        let found = asked(&ill);
        println!("{place}: out {:?}, named {:?}", out(&found), named(&found));
        if named(&found).is_empty() {
            assert!(place > 0, "the first is named");
            continue;
        }
        shown += 1;
        assert_eq!(named(&found).first(), Some(&"let_off_wide"), "{place}");
        let amount = erard_workshop::diagnose::injected_amount(found.causes[0].cause, found.causes[0].case);
        let cured = asked(&inject(&ill, found.causes[0].cause, amount, true, &mut |_| true).unwrap());
        println!("{place}: undone by {} mm of 0.3; still out: {:?}", -1e3 * amount, out(&cured));
        assert_eq!(out(&cured), out(&asked(healthy)), "{place}");
        assert!(place > 0 || !cured.is_work());
    }
    assert!(4 * shown >= 3 * pianos, "it is named on {shown} of {pianos}");
}

/// One fault each on drawn grands that the effects were not simulated on, read with a sheet's errors: the likeliest
/// cause is the planted one, and its probability is what is scored.
#[test]
#[ignore = "ci: 60 keys diagnosed"]
fn planted_faults() {
    let told = planted::told("fault", Reading::Sheet);
    let first = told.iter().filter(|one| one.is_first()).count();
    println!("{}first {first} of {}, log score {:.3}", planted::report(told), told.len(), planted::log_score(told));
    assert!(told.len() == 60 && first >= FIRST && planted::log_score(told) >= LOG_SCORE, "{first}");
}

/// What the ranking reaches on these: the likeliest cause, and the log score.
const FIRST: usize = 52;
const LOG_SCORE: f64 = -0.4;

/// 200 readings of sound keys with a bench's errors: at most one in twenty gets work.
#[test]
#[ignore = "ci: 200 keys diagnosed"]
fn sound_keys_get_no_work() {
    let (mut work, mut all) = (0, 0);
    for truth in planted::truths().iter().filter(|truth| truth.set == "sound") {
        let mut chance = crate::worklist::hand::Chance::new(7001 + all as u64);
        for _ in 0..25 {
            let mut known = proof::read_within(&truth.known, planted::bench_error, &mut chance);
            planted::ASKED.iter().for_each(|name| known.set(name, None));
            let found = diagnose(&known, KEY);
            for line in found.lines.iter().filter(|line| line.standing == Standing::Out) {
                println!("{} {} {:?}", truth.grand, line.name, line.value);
            }
            (work, all) = (work + usize::from(found.is_work()), all + 1);
        }
    }
    println!("{work} of {all} sound keys get work");
    assert!(all == 200 && 20 * work <= all, "{work} of {all}");
}

/// Causes on instruments of another make and on one that was put right, and the largest that are met, read with a
/// bench's errors: the likeliest cause of those that show is the planted one.
#[test]
#[ignore = "ci: 135 keys diagnosed"]
fn planted_on_other_instruments() {
    for (set, least, least_score) in [("other", OTHER, OTHER_SCORE), ("largest", LARGEST, LARGEST_SCORE)] {
        let told = planted::told(set, Reading::Bench);
        let shown: Vec<&planted::Told> = told.iter().filter(|one| one.found.is_work()).collect();
        let first = shown.iter().filter(|one| one.is_first()).count();
        let [low, high] = planted::interval(first, shown.len());
        let (of, score) = (shown.len(), planted::log_score(told));
        println!("{}{set}: {} planted, {of} show, first in {first}, ", planted::report(told), told.len());
        println!("{set}: {low:.2} to {high:.2}, log score {score:.3}");
        assert!(first as f64 >= least * of as f64 && score > least_score, "{set}: {first} of {of}, {score}");
    }
}

/// What the ranking reaches on these: the share that is the likeliest, and the log score.
const OTHER: f64 = 0.9;
const OTHER_SCORE: f64 = -0.35;
const LARGEST: f64 = 0.9;
const LARGEST_SCORE: f64 = -0.2;

/// Instruments whose leverage and strike weight are not the usual ones: every cause that is named is planted or
/// follows from one; nine keys of ten with a planted cause get one.
#[test]
#[ignore = "ci: 40 keys diagnosed"]
fn no_wrong_work_on_other_leverages_and_hammers() {
    let kinds = planted::told("kind", Reading::Bench);
    let refused = planted::truths().iter().filter(|truth| truth.set == "refused").count();
    let (mut right, mut wrong) = (0, 0);
    for one in kinds {
        let planted: Vec<&str> = one.planted.iter().map(|(cause, _)| *cause).collect();
        // Leads follow from the others, and come after them.
        let known = &one.truth.known;
        let is_for_leads =
            |by: f64| one.truth.beyond("strike_weight_ratio").max(one.truth.beyond("strike_weight_g")) < by;
        let due = |cause: &str| match cause {
            "leads_many" => known.get("front_weight_g").unwrap() > 30.0 && is_for_leads(0.25),
            "leads_few" => known.balance_g().unwrap() > 40.0 && is_for_leads(0.25),
            cause => planted.contains(&cause),
        };
        let named = named(&one.found);
        let is_wrong = named.iter().any(|cause| !due(cause));
        let is_right = !is_wrong && (planted.is_empty() || !named.is_empty());
        (right, wrong) = (right + usize::from(is_right), wrong + usize::from(is_wrong));
        if !is_right {
            println!(
                "  {} {}: planted {planted:?}, {named:?}, open {:?}",
                one.truth.grand,
                one.truth.planted,
                open(&one.found)
            );
        }
    }
    let ([low, high], score) = (planted::interval(right, kinds.len()), planted::log_score(kinds));
    println!("{right} of {} right, {low:.2} to {high:.2}, {wrong} with wrong work; {refused} refused", kinds.len());
    println!("log score {score:.3}");
    assert!(
        kinds.len() == 40 && wrong == 0 && 10 * right >= 9 * kinds.len(),
        "{right} right, {wrong} wrong of {}",
        kinds.len()
    );
}

/// Stated probabilities beside frequencies, by groups, within the interval that all groups keep together in 95 %. The
/// likeliest cause is the planted one as often as is said. No cause is planted more often than its probability says;
/// small ones are stated too large, and those of 80 to 95 %, too. What is all but certain is planted in more than 95 of
/// 100.
#[test]
#[ignore = "ci: 235 keys diagnosed"]
fn stated_probabilities_are_frequencies() {
    let mut told: Vec<&planted::Told> = planted::told("fault", Reading::Sheet).iter().collect();
    for set in ["other", "largest", "kind"] {
        told.extend(planted::told(set, Reading::Bench).iter().filter(|one| one.found.is_work()));
    }
    let likeliest: Vec<(f64, bool)> = told.iter().map(|one| (one.first.1, one.is_first())).collect();
    let every: Vec<(f64, bool)> = told.iter().flat_map(|one| one.all()).collect();
    // Mean stated probability, share that is right, and its interval, of those between two probabilities.
    let groups = |what: &str, all: &[(f64, bool)], ends: &[f64]| -> Vec<(f64, f64, [f64; 2])> {
        let group = |pair: &[f64]| {
            let of: Vec<&(f64, bool)> = all.iter().filter(|(p, _)| (pair[0]..pair[1]).contains(p)).collect();
            let right = of.iter().filter(|(_, is_planted)| *is_planted).count();
            let stated = of.iter().map(|(p, _)| p).sum::<f64>() / of.len().max(1) as f64;
            let [low, high] = planted::interval_of(right, of.len().max(1), 2.5);
            println!("{what}, stated {stated:.2}: {right} of {} right, {low:.2} to {high:.2}", of.len());
            (of.len() >= 5).then_some((stated, right as f64 / of.len() as f64, [low, high]))
        };
        ends.windows(2).filter_map(group).collect()
    };
    for (stated, _, [low, high]) in groups("likeliest", &likeliest, &[0.0, 0.5, 0.8, 0.95, 1.001]) {
        assert!((low..=high).contains(&stated), "likeliest: {stated} {low} {high}");
    }
    for (stated, share, [low, _]) in groups("every cause", &every, &[0.02, 0.1, 0.25, 0.5, 0.8, 0.95, 1.001]) {
        assert!(low <= stated && (stated < 0.95 || share > 0.95), "every cause: {stated} {share} {low}");
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
        let tally = super::tally(&super::sound_samples(GRAND, 8, 5001), 60, 20, 0);
        println!("{}", tally.report());
        assert_eq!((tally.pianos(), tally.healthy), (60, [20; 2]), "{}", tally.report());
        assert!(tally.first(2) >= 50, "{}", tally.report());
    }

    /// The file's readings are those of the simulation.
    #[test]
    #[ignore = "nightly: 9 drawn grands, 255 actions measured"]
    fn planted_pianos_are_what_is_simulated() {
        let text = super::planted::simulate();
        if let Some(folder) = std::env::var_os("ERARD_REGENERATE") {
            let path = std::path::Path::new(&folder).join("crates/erard-workshop/tests/planted.csv");
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
            return;
        }
        let [own, now] = [super::planted::truths(), super::planted::parse(&text)];
        assert_eq!(own.len(), now.len());
        for (own, now) in own.iter().zip(&now) {
            assert_eq!((&own.set, &own.grand, &own.planted), (&now.set, &now.grand, &now.planted));
            for entry in erard_workshop::diagnose::entries() {
                let [a, b] = [own, now].map(|truth| truth.known.get(entry.name));
                let is_near = a.is_some() == b.is_some() && a.zip(b).is_none_or(|(a, b)| (a - b).abs() < 0.01);
                assert!(is_near, "{own:?} {}: {a:?} {b:?}", entry.name);
            }
        }
    }

    /// Effects of two causes add: on twenty pairs the sum of two effects misses that of both together by less than the
    /// quarter of it by which pianos of another make may differ, which the ranking allows for.
    #[test]
    #[ignore = "nightly: a drawn grand, 40 measured"]
    fn effects_of_two_causes_add() {
        let (_, grand) = super::sound_samples(GRAND, 1, 5001).swap_remove(0);
        let pairs: Vec<[usize; 2]> = (0..causes().len()).map(|at| [at, (at + 7) % causes().len()]).take(20).collect();
        let known = |instrument: &Instrument| super::Known::measured(instrument, &mut |_| true).unwrap();
        let sound = known(&grand);
        let with = |at: usize| super::proof::with(&grand, Some(at), 2.0);
        let alone: Vec<super::Known> = (0..causes().len()).map(|at| known(&with(at))).collect();
        let (mut missed, mut effect, mut near, mut all) = (0.0, 0.0, 0, 0);
        for [a, b] in pairs {
            let both = known(&super::proof::with(&with(a), Some(b), 2.0));
            for entry in erard_workshop::diagnose::entries() {
                let of = |known: &super::Known| Some(known.get(entry.name)? - sound.get(entry.name)?);
                let (Some(one), Some(other), Some(together)) = (of(&alone[a]), of(&alone[b]), of(&both)) else {
                    continue;
                };
                if one.abs().max(other.abs()) < entry.precision {
                    continue;
                }
                let off = (together - one - other) / entry.precision;
                missed += off * off;
                effect += (together / entry.precision).powi(2);
                (near, all) = (near + usize::from(off.abs() <= 1.0), all + 1);
                if off.abs() > 2.0 {
                    let [one, other, together] = [one, other, together].map(|x| format!("{x:.2}"));
                    println!("{} + {}: {} {one} + {other}, {together}", causes()[a].key, causes()[b].key, entry.name);
                }
            }
        }
        let share = (missed / effect).sqrt();
        println!("{near} of {all} readings within their precision; {share:.3} of the effect is missed");
        assert!(share < 0.25 && 10 * near > 7 * all, "{share} {near} {all}");
    }
}
