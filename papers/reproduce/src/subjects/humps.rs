//! A key that is let go beside recorded ones, from its landing on: how often it comes back, when and how far.

use super::{Chart, ChartCurve, ChartPanel, Dash, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard_workshop::validate::release::{HELD_N, let_go_course};

/// Travel of the recorded key in the six releases that let it go, and what was measured of every recorded release
/// (`recordings/README.md`).
const TRAVELS: &str = include_str!("../../../../crates/erard-core/recordings/kawai-kg-3c-let-go.csv");
const RELEASES: &str = include_str!("../../../../crates/erard-core/recordings/kawai-kg-3c-releases.csv");
/// What the sensor does not resolve near the key's rest, mm.
const SENSOR_MM: f64 = 0.2;
/// Heights of the panel that shows the humps, mm, and colours of recorded and modelled keys.
const NEAR_REST_MM: (f64, f64) = (-0.5, 4.0);
const RECORDED: usize = 0;
const MODELLED: usize = 1;

/// Travel of a key, ms after its landing and mm.
#[derive(Default)]
struct Travel {
    time_ms: Vec<f64>,
    key_mm: Vec<f64>,
}

/// The recorded travels. All have the same times.
fn recorded() -> Vec<Travel> {
    let mut travels: Vec<Travel> = Vec::new();
    let mut last = None;
    for line in TRAVELS.lines().skip(1) {
        let mut cells = line.split(',');
        let (release, numbers) = (cells.next(), cells.skip(1).filter_map(|cell| cell.parse::<f64>().ok()));
        let [time_ms, key_mm] = numbers.collect::<Vec<_>>()[..] else { continue };
        if last.replace(release) != Some(release) {
            travels.push(Travel::default());
        }
        if let Some(travel) = travels.last_mut() {
            travel.time_ms.push(time_ms);
            travel.key_mm.push(key_mm);
        }
    }
    travels
}

/// Adds picture and table to the subject.
pub(super) fn add(instrument: &Instrument, section: &mut Section) -> Result<(), ReproduceError> {
    let course = let_go_course(instrument, HELD_N, &mut |_| true)
        .map_err(|error| ReproduceError::Instrument(error.to_string()))?;
    let recorded = recorded();
    let within = recorded.first().map_or([0.0; 2], |one| [one.time_ms[0], one.time_ms[one.time_ms.len() - 1]]);
    let travel = course.travel().into_iter().map(|[s, m]| [1e3 * s, 1e3 * m]);
    let shown = travel.filter(|[ms, _]| (within[0]..=within[1]).contains(ms));
    let (time_ms, key_mm) = shown.map(|[ms, mm]| (ms, mm)).unzip();
    section.charts.push(chart(&recorded, &Travel { time_ms, key_mm }));

    let header = ["release", "humps", "first (ms)", "first (mm)", "second (ms)", "second (mm)"];
    let mut table = Table::new("A key let go: tops of its humps after landing", &header);
    for line in RELEASES.lines().filter(|line| line.contains(",let go,")) {
        let cells: Vec<&str> = line.split(',').collect();
        let [release, _, role, _, _, _, _, humps, tops @ ..] = &cells[..] else { continue };
        let tops = tops.iter().map(|&cell| cell.to_owned());
        table.row([format!("recorded, {release} ({role})"), (*humps).to_owned()].into_iter().chain(tops));
    }
    let humps = course.release().humps.unwrap_or_default();
    let of = |n: usize| match humps.get(n) {
        Some(hump) => [format!("{:.1}", 1e3 * hump.top_s), format!("{:.2}", 1e3 * hump.height_m)],
        None => ["-", "-"].map(str::to_owned),
    };
    let tops = [of(0), of(1)].concat();
    table.row(["modelled".to_owned(), humps.len().to_string()].into_iter().chain(tops));
    section.tables.push(table);
    Ok(())
}

fn chart(recorded: &[Travel], modelled: &Travel) -> Chart {
    let curve = |label: &str, travel: &Travel, colour, mark| ChartCurve {
        label: label.to_owned(),
        x: travel.time_ms.clone(),
        y: travel.key_mm.clone(),
        colour,
        mark,
    };
    // One name for all six, and one for both edges of the band.
    let named = |n: usize, name: &'static str| if n == 0 { name } else { "" };
    let keys = || {
        let six = recorded.iter().enumerate();
        let six = six.map(|(n, one)| curve(named(n, "recorded, six releases"), one, RECORDED, Dash::Dashed));
        six.chain([curve("modelled", modelled, MODELLED, Dash::Solid)])
    };
    let edge = |pick: fn(f64, f64) -> f64, by_mm: f64| {
        let at = |row: usize| recorded.iter().map(|one| one.key_mm[row]).reduce(pick).map_or(f64::NAN, |y| y + by_mm);
        let time_ms = recorded.first().map(|one| one.time_ms.clone()).unwrap_or_default();
        Travel { key_mm: (0..time_ms.len()).map(at).collect(), time_ms }
    };
    let edges = [edge(f64::max, SENSOR_MM), edge(f64::min, -SENSOR_MM)];
    let band = edges.iter().enumerate();
    let band = band.map(|(n, one)| curve(named(n, "all six, +-0.2 mm"), one, RECORDED, Dash::Dotted));
    let panel = |y_label: &str, y_range, curves| ChartPanel { y_label: y_label.into(), y_log: false, y_range, curves };
    Chart {
        title: "The return of a key let go, recorded and modelled".into(),
        caption: format!(
            "0 ms: the key lands, 0.5 mm below its rest. Travel of its back, as at the front. The model is held with \
             {HELD_N} N, which vanish within 2 ms. Dotted: {SENSOR_MM} mm more than the highest and less than the lowest \
             recorded travel; near rest the sensor resolves no more"
        ),
        x_label: "time after landing (ms)".into(),
        x_log: false,
        panels: vec![
            panel("key, down (mm)", None, keys().collect()),
            panel("near its rest (mm)", Some(NEAR_REST_MM), keys().chain(band).collect()),
        ],
    }
}
