//! Work list: each line is worked out on a copy with the lines before it done.

pub mod hand;
mod keyboard;
mod proof;

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use erard::instrument::{Instrument, InstrumentFile};
use erard_workshop::sample::Sampled;
use erard_workshop::worklist::{Left, Priority, ReadingQuantity, Readings, Work, Worklist, worklist};
use hand::KEY;
use proof::{Course, Tally, course, is_healthy};

fn list_of(instrument: &Instrument) -> Worklist {
    let go_on = &mut |_: f64| true;
    let readings = Readings::of(instrument, go_on).unwrap();
    worklist(instrument, &readings, &[], Priority::Aftertouch, go_on).unwrap()
}

/// No line requests less than a hand can do and a scale can show.
fn assert_lines_can_be_seen(list: &Worklist) {
    for item in &list.items {
        let change = item.before.get(item.quantity).zip(item.after.get(item.quantity)).map(|(a, b)| (b - a).abs());
        let least = item.quantity.least_change();
        assert!(change.is_none_or(|change| change >= 0.999 * least), "{item:?}");
        assert!(item.work.amount().abs() >= 0.999 * item.work.step(), "{item:?}");
    }
}

/// One front punching too few: the list adds paper, and nothing in range leaves it. Its predictions are the copy's
/// readings.
#[test]
#[ignore = "ci: a list carried out"]
fn a_dip_too_deep_gets_paper() {
    let mut instrument = Instrument::builtin("concert-grand").unwrap();
    let screw = instrument.screw("front_punching").unwrap();
    let setting = instrument.screws[screw].setting - 0.8e-3;
    assert!(instrument.turn(screw, setting));
    let list = list_of(&instrument);
    assert!(list.before.is_out(ReadingQuantity::Aftertouch, KEY));
    let paper = list.items.iter().find(|item| item.quantity == ReadingQuantity::Dip).unwrap();
    assert!(
        matches!(paper.work, Work::Screw { name: "front_punching", by } if (3e-4..1.2e-3).contains(&by)),
        "{paper:?}"
    );
    assert_eq!(list.left, []);
    assert_lines_can_be_seen(&list);
    let read = Readings::of(&list.copy, &mut |_| true).unwrap();
    for quantity in ReadingQuantity::ALL {
        assert!(!read.is_out(quantity, KEY), "{quantity:?} {:?}", read.get(quantity));
        let [promised, found] = [list.after.get(quantity), read.get(quantity)].map(Option::unwrap);
        assert!((promised - found).abs() < 1e-6, "{quantity:?}: {promised} {found}");
    }
}

/// The heavy action of the book, whose old list made a dead key: friction first, and all lines inside except the front
/// weight, which the list reports as left.
#[test]
#[ignore = "ci: some twenty regulations"]
fn heavy_touch_is_put_right() {
    let heavy = Instrument::builtin("heavy-touch").unwrap();
    let list = list_of(&heavy);
    assert_eq!(list.items.first().map(|item| item.quantity), Some(ReadingQuantity::FrictionWeight));
    let left: Vec<ReadingQuantity> = list.left.iter().map(|left: &Left| left.quantity).collect();
    assert_eq!(left, [ReadingQuantity::FrontWeight], "{:?}", list.left);
    assert_lines_can_be_seen(&list);
    let read = Readings::of(&list.copy, &mut |_| true).unwrap();
    for quantity in ReadingQuantity::ALL {
        assert_eq!(read.is_out(quantity, KEY), left.contains(&quantity), "{quantity:?} {:?}", read.get(quantity));
    }
}

/// Pianos unknown to the program: healthy samples, from a number on, are put out of order, and worked on twice. All
/// cores work; the tally does not depend on their number.
fn tally(pianos: usize, first: u32) -> Tally {
    const GRAND: &str = "concert-grand";
    let go_on = &mut |_: f64| true;
    let text = Instrument::builtin_text(GRAND).unwrap();
    let model = Instrument::builtin(GRAND).unwrap();
    let sampled = Sampled::of_file(text, GRAND, go_on).unwrap();
    let (next, courses) = (AtomicU32::new(first), Mutex::new(BTreeMap::new()));
    let of_first = |courses: &BTreeMap<u32, Course>| {
        let mut tally = Tally::default();
        courses.iter().take(pianos).for_each(|(number, course)| tally.add(*number, course));
        tally
    };
    let work = || {
        let go_on = &mut |_: f64| true;
        while courses.lock().unwrap().len() < pianos {
            let number = next.fetch_add(1, Ordering::SeqCst);
            let text = sampled.text(number, go_on).unwrap();
            let healthy = InstrumentFile::parse(&text, GRAND).unwrap().instrument;
            if is_healthy(&Readings::of(&healthy, go_on).unwrap()) {
                let course = course(&healthy, &model, u64::from(number));
                let mut courses = courses.lock().unwrap();
                courses.insert(number, course);
                let mut alone = Tally::default();
                alone.add(number, &courses[&number]);
                alone.wrong().for_each(|line| println!("  {line}"));
                println!("up to sample {number}: {}", of_first(&courses).counts());
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from).min(pianos) {
            scope.spawn(work);
        }
    });
    let tally = of_first(&courses.lock().unwrap());
    println!("{}", tally.report());
    tally
}

mod nightly {
    /// One piano, with both passes.
    #[test]
    #[ignore = "nightly: a drawn piano, regulated some forty times"]
    fn a_piano_that_is_not_known_is_put_right() {
        let tally = super::tally(1, 1);
        let [before, one, two] = tally.inside;
        // A second pass may end a line outside by less than its precision; the checks below require a reason.
        assert!(tally.pianos == 1 && before < one && before < two, "{}", tally.report());
        assert!(tally.without_reason.is_empty() && tally.made_worse.is_empty(), "{}", tally.report());
    }

    /// 200 pianos: 95 % of all lines are inside their ranges after one pass, after two every line outside has a reason,
    /// and no pass moves a line out of its range, or further out, by more than its reading's precision.
    ///
    /// This takes half an hour on two cores: `ERARD_PIANOS=50 ERARD_FIRST_SAMPLE=200` tests fifty, from sample 200 on.
    #[test]
    #[ignore = "nightly: 200 drawn pianos, each regulated some forty times"]
    fn pianos_that_are_not_known_are_put_right() {
        let given = |name: &str, usual: u32| std::env::var(name).map_or(usual, |text| text.parse().unwrap());
        let pianos = given("ERARD_PIANOS", 200) as usize;
        let tally = super::tally(pianos, given("ERARD_FIRST_SAMPLE", 1));
        let [_, one, two] = tally.inside;
        assert!(tally.pianos == pianos && 20 * one >= 19 * tally.lines && one <= two, "{}", tally.report());
        assert!(tally.without_reason.is_empty() && tally.made_worse.is_empty(), "{}", tally.report());
    }
}
