//! What `erard keyboard` makes of the keys that it has weighed: text, table, figure.

pub(crate) mod pair;

use erard::keyboard::KEYS;
use erard::trust::worst_of_each;
use erard_workshop::test_press::TestPress;
use erard_workshop::weighing::WeighedKey;

use crate::table::{Table, decimal};
use erard_figures::Picture;
use erard_figures::figure::{Dash, Figure, Panel, Trace, figure_picture};

/// Notes that a technician samples: the lowest, pairs of neighbours in bass, middle and treble, and the highest. The
/// nearest that were weighed stand in the text.
const SAMPLES: [usize; 8] = [1, 16, 17, 40, 41, 64, 65, 88];

/// The columns.
const COLUMNS: [&str; 12] = [
    "key",
    "note",
    "hammer_mass_g",
    "strike_weight_g",
    "front_weight_g",
    "down_weight_g",
    "up_weight_g",
    "balance_weight_g",
    "friction_weight_g",
    "mf_hammer_speed_m_per_s",
    "trusted",
    "error",
];
/// Where the trust in a row is among its numbers.
const TRUSTED: usize = 8;
/// Of these stand in the text: those in grams.
const GRAMS: std::ops::Range<usize> = 2..9;

/// The numbers of a row, in the order of the columns after the note; not a number where there is none.
fn numbers(weighed: &WeighedKey) -> [f64; 9] {
    let number = |weight: Option<f64>| weight.unwrap_or(f64::NAN);
    let Ok(weighed) = &weighed.weights else {
        let mut none = [f64::NAN; 9];
        none[TRUSTED] = 0.0;
        return none;
    };
    [
        weighed.hammer_mass_g,
        weighed.strike_weight_g,
        weighed.front_weight_g,
        number(weighed.touch.down_weight_g),
        number(weighed.touch.up_weight_g),
        number(weighed.touch.balance_weight_g()),
        number(weighed.touch.friction_weight_g()),
        number(weighed.test_press.hammer_speed_m_per_s),
        f64::from(u8::from(weighed.test_press.warnings.is_empty())),
    ]
}

/// Keys without all of their weights, each with the reason, and why others cannot be trusted.
pub(crate) fn warnings(weighed: &[WeighedKey]) -> Vec<String> {
    let failed = weighed.iter().filter_map(|one| Some(format!("key {}: {}", one.key, one.error()?)));
    let tried = weighed.iter().filter_map(|one| Some((one.key, &one.weights.as_ref().ok()?.test_press)));
    failed.chain(doubts(tried)).collect()
}

/// Why keys cannot be trusted, each tried with its number: of every kind and part how many keys, and the worst of
/// them.
pub(crate) fn doubts<'a>(tried: impl Iterator<Item = (usize, &'a TestPress)> + Clone) -> Vec<String> {
    let all = tried.clone().count();
    worst_of_each(tried.clone().flat_map(|(_, one)| &one.warnings))
        .into_iter()
        .map(|(count, worst)| {
            let key = tried.clone().find(|(_, one)| one.warnings.contains(worst)).map_or(0, |(key, _)| key);
            format!("{count} of {all} keys pressed mezzo forte cannot be trusted; the worst, key {key}: {worst}")
        })
        .collect()
}

/// Where the sample notes stand among the keys that were weighed.
fn samples(weighed: &[WeighedKey]) -> Vec<usize> {
    let nearest = |key: &usize| (0..weighed.len()).min_by_key(|&at| weighed[at].key.abs_diff(*key));
    let mut samples: Vec<usize> = SAMPLES.iter().filter_map(nearest).collect();
    samples.dedup();
    samples
}

/// The first lines: the weights at both ends of what was weighed.
pub(crate) fn headlines(weighed: &[WeighedKey]) -> Vec<String> {
    let mut ends = weighed.iter().filter(|one| one.weights.is_ok());
    let Some(first) = ends.next() else { return Vec::new() };
    let last = ends.next_back().unwrap_or(first);
    let from_to = |column: usize| {
        let [from, to] = [first, last].map(|one| decimal(Some(numbers(one)[column]), 1));
        format!("{from} g to {to} g")
    };
    vec![
        format!(
            "From {} to {} the down-weight goes from {}, the up-weight from {}.",
            first.note,
            last.note,
            from_to(3),
            from_to(4)
        ),
        format!("Balance weight: {}. Friction weight: {}.", from_to(5), from_to(6)),
        format!("Hammer with its shank: {}. Front weight of the key: {}.", from_to(0), from_to(2)),
    ]
}

/// The table for people: a row per quantity, a column per sample of the keys.
pub(crate) fn text(weighed: &[WeighedKey]) -> String {
    let samples: Vec<&WeighedKey> = samples(weighed).into_iter().map(|at| &weighed[at]).collect();
    let row = |name: &str, unit: &str, cell: &dyn Fn(&WeighedKey) -> String| {
        let cells = samples.iter().map(|one| cell(one));
        std::iter::once(name.to_owned()).chain(cells).chain([unit.to_owned()]).collect::<Vec<_>>()
    };
    let mut rows = vec![row("note", "", &|one| one.note.clone())];
    for (column, name) in COLUMNS[GRAMS].iter().enumerate() {
        let name = name.trim_end_matches("_g").replace('_', " ");
        let name = name.replace("down weight", "down-weight").replace("up weight", "up-weight");
        rows.push(row(&name, "g", &|one| decimal(Some(numbers(one)[column]), 1)));
    }
    let mut out = Table::of(row("key", "", &|one| one.key.to_string()), rows).to_string();
    if samples.len() < weighed.len() {
        out += &format!("\n  {} of {} keys; keyboard.csv holds every one\n", samples.len(), weighed.len());
    }
    out
}

/// All keys, for a file: what is not known is empty.
pub(crate) fn table(weighed: &[WeighedKey]) -> Table<'static> {
    let table = Table::default()
        .optional(COLUMNS[0], weighed.iter().map(|one| Some(one.key as f64)))
        .words(COLUMNS[1], weighed.iter().map(|one| one.note.clone()));
    let table = COLUMNS[2..=2 + TRUSTED]
        .iter()
        .enumerate()
        .fold(table, |table, (index, name)| table.optional(*name, weighed.iter().map(|one| Some(numbers(one)[index]))));
    table.words(COLUMNS[3 + TRUSTED], weighed.iter().map(|one| one.error().unwrap_or_default()))
}

/// What the abscissa over the keys of a piano counts.
pub(crate) const KEY_NUMBERS: &str = "number of the key, 1 = A0, 40 = C4, 88 = C8";

/// Panels over the keys of a piano.
fn over_the_keys(title: String, panels: Vec<Panel>) -> Picture {
    let subtitle = "touch weights as measured in a slow loop, dampers lifted".into();
    figure_picture(&Figure::over(KEY_NUMBERS, (1.0, KEYS as f64), title, subtitle, panels))
}

/// Hammers and leads, and the touch weights, over the number of the key.
pub(crate) fn weighed_picture(name: &str, weighed: &[WeighedKey]) -> Picture {
    let keys: Vec<f64> = weighed.iter().map(|w| w.key as f64).collect();
    let curve = |label: &str, index: usize, style: usize, dash| {
        let y: Vec<f64> = weighed.iter().map(|w| numbers(w)[index]).collect();
        Trace::new(label, &keys, y, style, dash)
    };
    let panel = |quantity: &str, height_px, curves| Panel::new(quantity, "g", height_px, curves);
    let panels = vec![
        panel(
            "hammer",
            150.0,
            vec![curve("mass, with shank", 0, 0, Dash::Solid), curve("strike weight", 1, 1, Dash::Dashed)],
        ),
        panel("key", 130.0, vec![curve("front weight", 2, 2, Dash::Solid)]),
        panel(
            "touch",
            220.0,
            vec![
                curve("down-weight", 3, 0, Dash::Solid),
                curve("balance weight", 5, 6, Dash::Dashed),
                curve("up-weight", 4, 1, Dash::Solid),
                curve("friction weight", 6, 3, Dash::Dotted),
            ],
        ),
    ];
    over_the_keys(format!("{name}: hammers, leads and touch weights over the keyboard"), panels)
}
