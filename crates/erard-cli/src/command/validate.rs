//! `erard validate`.

use super::bands::{self, BandOptions, BandRow, Banded};
use super::cases;
use super::out::OutOptions;
use super::sound;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::instruments::{KeyboardKey, load_instrument_and_text};
use crate::print_line;
use crate::session::Session;
use crate::table::{Table, three};
use clap::Args;
use erard::instrument_spec::InstrumentSpec;
use erard::key::keys_named;
use erard::keyboard::Keyboard;
use erard_figures::Picture;
use erard_figures::figure::{Dash, Figure, Marker, Panel, Trace, figure_picture};
use erard_workshop::sample::unless_interrupted;
use erard_workshop::validate::{
    BesideGrands, Drive, GroupResult, Published, PublishedRow, SimulatedPress, Tally, Validation, Verdict, validate,
};
use serde::Serialize;
use serde_json::Value;

/// Text below the options.
const AFTER: &str = include_str!("help/validate.txt");

/// Compares an instrument with published measurements of real pianos.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Validate {
    /// Instrument: a TOML file, or a built-in name
    #[arg(long, value_name = "FILE-OR-NAME", default_value = "concert-grand")]
    instrument: InstrumentSpec,
    /// Diagnose published pianos instead, and compare the answers with what technicians concluded or found: all of
    /// them, those that choose or judge, or those with these names
    #[arg(
        long,
        value_name = "NAME,NAME,..",
        num_args = 0..=1,
        default_missing_value = "all",
        value_parser = cases::which,
        conflicts_with_all = ["instrument", "bands"]
    )]
    cases: Option<cases::Which>,
    /// Play notes instead, and compare their decay and timbre with those of a recorded grand: all 30 notes that were
    /// recorded, or those of these keys (numbers or notes with commas, `C2..C6` for a range). Needs a keyboard with
    /// modal strings: --instrument concert-grand-strings
    #[arg(
        long,
        value_name = "KEYS",
        num_args = 0..=1,
        default_missing_value = "A0..C8",
        value_parser = keys,
        conflicts_with_all = ["cases", "bands"]
    )]
    sound: Option<Keys>,
    /// Exit with code 1 if a row is missed
    #[arg(long)]
    fail_on_miss: bool,
    #[command(flatten)]
    bands: BandOptions,
    #[command(flatten)]
    out: OutOptions,
}

/// Keys of a list.
#[derive(Debug, Clone)]
struct Keys(Vec<usize>);

fn keys(text: &str) -> Result<Keys, String> {
    keys_named(text).map(Keys).map_err(|error| error.to_string())
}

impl Validate {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        if let Some(which) = &self.cases {
            return cases::run(session, &self.out, which, self.fail_on_miss);
        }
        if let Some(Keys(keys)) = &self.sound {
            return sound::run(session, &self.out, &self.instrument, keys, self.fail_on_miss);
        }
        self.bands.check(&self.instrument)?;
        let (instrument, text) = load_instrument_and_text(session, &self.instrument)?;
        let keyboard = match KeyboardKey::asked(session, &self.instrument)? {
            Some(one) => Some(one.keyboard),
            None => Keyboard::builtin(&self.instrument.base().to_string()).ok(),
        };
        // A sample's other keys are graded from the sample.
        let around = |text: &str| keyboard.as_ref().and_then(|keyboard| keyboard.around(text.to_owned()).ok());
        let keyboard = if self.instrument.sample().is_some() { around(&text) } else { keyboard.clone() };
        let published = Published::builtin();
        let mut output = self.out.prepare(
            session,
            "validate",
            &["validate.json", "validate.csv", "order-of-events.svg", "order-of-events.png"],
        )?;
        let mut progress = session.progress("validating");
        let validation = validate(&instrument, keyboard.as_ref(), &published, &mut |share| progress.tell(share))
            .map_err(|error| Failure::Measure { label: self.instrument.to_string(), error: Box::new(error) })?;
        drop(progress);

        let bands = match self.bands.bands {
            Some(count) => Some(self.banded(session, &published, &validation, keyboard.as_ref(), count)?),
            None => None,
        };
        let picture = order_picture(&validation, &published);
        let mut report = Report::new(&validation, &published);
        if let Some(bands) = &bands {
            report.take_bands(&bands.rows, &published);
            bands.stage_failed(session, &mut output)?;
        }
        output.json(session, "validate.json", &report)?;
        output.table(session, "validate.csv", &Table::of_records(&report.rows)?)?;
        output.figure(session, "order-of-events", &picture)?;
        let written = output.commit(session)?;

        let mut answer = Answer::of(&report)?;
        if let Some(bands) = &bands {
            answer = answer.with("failed_samples", &bands.failed)?;
        }
        print_line!(session, "{} compared with measured pianos", validation.instrument);
        answer.begin(
            session,
            headlines,
            "every row with its published range and the likely reason of a miss, the groups, and the timing beside three \
             grands",
        );
        print_line!(
            session,
            "Predicted: {} of {} rows met; {} of {} groups without a miss. Set: {} of {} met.",
            report.predicted.met,
            report.predicted.judged,
            report.whole_groups(),
            report.groups.iter().filter(|group| group.predicted.judged > 0).count(),
            report.set.met,
            report.set.judged
        );
        if report.undecided > 0 {
            print_line!(
                session,
                "{} rows cannot be judged: their bands are wider than the published ranges",
                report.undecided
            );
        }
        print_line!(session, "{} rows are beyond the model, {} have no published value", report.silent, report.open);
        print_line!(session);
        print_groups(session, &report.groups);
        print_table(session, &report.rows);
        print_grands(session, &report.grands);
        let answer = answer.end(session, &written);
        match report.missed {
            missed if missed > 0 && self.fail_on_miss => {
                let names: Vec<&str> = report
                    .rows
                    .iter()
                    .filter(|row| [MISSED, ABSENT].contains(&row.verdict))
                    .map(|row| row.name)
                    .collect();
                Ok(answer.short_of(Some(format!("{missed} rows missed: {}", names.join(", ")))))
            }
            _ => Ok(answer),
        }
    }
}

/// Rows that are farthest out, in the first lines.
const WORST: usize = 3;

/// The first lines: how many published values are met, in which groups not, and what is farthest out.
fn headlines(answer: &Value) -> Vec<String> {
    let tally = |of: &Value| [&of["met"], &of["judged"]].map(|count| count.as_u64().unwrap_or(0));
    let ([met, judged], [set_met, set]) = (tally(&answer["predicted"]), tally(&answer["set"]));
    let mut lines = vec![
        format!("Of {judged} published values that nothing was set to, {met} lie in their range."),
        format!("Of {set} values that it was built or regulated to, {set_met} do."),
    ];
    let missed = answer["groups"].as_array().into_iter().flatten().filter_map(|group| {
        let [met, judged] = tally(&group["predicted"]);
        (met < judged).then(|| format!("{} {met} of {judged}", group["title"].as_str().unwrap_or_default()))
    });
    let missed: Vec<String> = missed.collect();
    lines.push(match missed.len() {
        0 => "No group has a miss.".to_owned(),
        _ => format!("Groups with a miss: {}.", missed.join(", ")),
    });
    if let Some(undecided) = answer["undecided"].as_u64().filter(|count| *count > 0) {
        lines.push(format!("{undecided} cannot be judged: their bands are wider than the published ranges."));
    }
    // By how many widths of its range.
    let width = |row: &Value| row["at_most"].as_f64().zip(row["at_least"].as_f64()).map(|(high, low)| high - low);
    let far = |row: &Value| Some(row["missed_by"].as_f64()?.abs() / width(row).filter(|width| *width > 0.0)?);
    let rows = answer["rows"].as_array().into_iter().flatten();
    let mut out: Vec<(f64, &Value)> = rows.filter_map(|row| Some((far(row)?, row))).collect();
    out.sort_by(|a, b| b.0.total_cmp(&a.0));
    if !out.is_empty() {
        lines.push("Farthest out, in widths of the range:".to_owned());
    }
    for (_, row) in out.iter().take(WORST) {
        let text = |key: &str| row[key].as_str().unwrap_or_default();
        let number = |key: &str| row[key].as_f64().unwrap_or(f64::NAN);
        let band = row["band_low"].as_f64().zip(row["band_high"].as_f64());
        let band = band.map_or_else(String::new, |(low, high)| format!(" ({} to {})", three(low), three(high)));
        let (found, unit) = (three(number("simulated")), text("unit"));
        let range = format!("{} to {}", number("at_least"), number("at_most"));
        lines.push(format!("  {}: {found}{band} {unit}, published {range}", text("quantity")).replace(" ,", ","));
    }
    lines
}

/// A row of the table with its verdict, as it is written and printed.
#[derive(Debug, Serialize)]
struct RowReport<'a> {
    name: &'a str,
    quantity: &'a str,
    group: &'a str,
    kind: &'static str,
    set_by: Option<&'a str>,
    unit: &'a str,
    published: String,
    at_least: Option<f64>,
    at_most: Option<f64>,
    simulated: Option<f64>,
    band_low: Option<f64>,
    band_high: Option<f64>,
    verdict: &'static str,
    missed_by: Option<f64>,
    z: Option<f64>,
    source: &'a str,
    source_title: &'a str,
    certainty: erard::instrument::Certainty,
    how: &'a str,
    likely_reason: Option<&'a str>,
    constant_force: Option<f64>,
}

#[derive(Debug, Serialize)]
#[allow(non_snake_case)]
struct PressReport {
    #[serde(skip_serializing_if = "Option::is_none")]
    force_N: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rate_N_s: Option<f64>,
    key_stroke_ms: Option<f64>,
    hammer_before_key_bottom_ms: Option<f64>,
    hammer_speed_m_per_s: Option<f64>,
    key_speed_m_per_s: f64,
    string_contact_ms: Option<f64>,
}

#[derive(Debug, Clone, Copy, Serialize)]
struct TallyReport {
    met: usize,
    judged: usize,
}

impl From<Tally> for TallyReport {
    fn from(Tally { met, judged }: Tally) -> Self {
        TallyReport { met, judged }
    }
}

/// A group of rows.
#[derive(Debug, Serialize)]
struct GroupReport {
    name: String,
    title: String,
    predicted: TallyReport,
    set: TallyReport,
    /// Rows whose band is wider than what was published.
    undecided: usize,
    z: Option<f64>,
    z_set: Option<f64>,
}

impl From<GroupResult> for GroupReport {
    fn from(GroupResult { name, title, set, predicted, z, z_set }: GroupResult) -> Self {
        GroupReport { name, title, predicted: predicted.into(), set: set.into(), undecided: 0, z, z_set }
    }
}

/// Timing at a level, beside published grands.
#[derive(Debug, Serialize)]
struct GrandsReport {
    touch: &'static str,
    hammer_speed_m_per_s: f64,
    travel_ms: Option<f64>,
    travel_of_hand_ms: Option<f64>,
    key_bottom_ms: Option<f64>,
    free_flight_ms: Option<f64>,
    off_knuckle_ms: Option<f64>,
    grands: Vec<GrandReport>,
}

#[derive(Debug, Serialize)]
struct GrandReport {
    grand: &'static str,
    travel_ms: f64,
    key_bottom_ms: f64,
    free_flight_ms: f64,
}

impl From<&BesideGrands> for GrandsReport {
    fn from(one: &BesideGrands) -> Self {
        let grand = |&(grand, [travel_ms, key_bottom_ms, free_flight_ms]): &(&'static str, [f64; 3])| GrandReport {
            grand,
            travel_ms,
            key_bottom_ms,
            free_flight_ms,
        };
        GrandsReport {
            touch: one.touch.name(),
            hammer_speed_m_per_s: one.speed_m_per_s,
            travel_ms: one.travel_ms,
            travel_of_hand_ms: one.travel_of_hand_ms,
            key_bottom_ms: one.key_bottom_ms,
            free_flight_ms: one.free_flight_ms,
            off_knuckle_ms: one.off_knuckle_ms,
            grands: one.grands.iter().map(grand).collect(),
        }
    }
}

#[derive(Debug, Serialize)]
struct Report<'a> {
    instrument: &'a str,
    predicted: TallyReport,
    set: TallyReport,
    groups: Vec<GroupReport>,
    met: usize,
    missed: usize,
    undecided: usize,
    silent: usize,
    open: usize,
    rows: Vec<RowReport<'a>>,
    constant_force: Vec<PressReport>,
    pressed: Vec<PressReport>,
    grands: Vec<GrandsReport>,
}

impl<'a> Report<'a> {
    fn new(validation: &'a Validation, published: &'a Published) -> Self {
        let rows: Vec<RowReport<'a>> = published
            .rows
            .iter()
            .zip(validation.verdicts.iter().zip(&validation.beside))
            .map(|(row, (verdict, beside))| RowReport::new(row, *verdict, *beside, published))
            .collect();
        let count = |verdicts: &[&str]| rows.iter().filter(|row| verdicts.contains(&row.verdict)).count();
        let groups: Vec<GroupReport> = validation.groups(published).into_iter().map(Into::into).collect();
        let all = |of: fn(&GroupReport) -> TallyReport| {
            let sum = |tally: TallyReport, one: TallyReport| TallyReport {
                met: tally.met + one.met,
                judged: tally.judged + one.judged,
            };
            groups.iter().map(of).fold(TallyReport { met: 0, judged: 0 }, sum)
        };
        let ms = |s: Option<f64>| s.map(|s| s * 1e3);
        let press = |b: &SimulatedPress| PressReport {
            force_N: if let Drive::Constant(force) = b.drive { Some(force) } else { None },
            rate_N_s: if let Drive::Pressed(rate) = b.drive { Some(rate) } else { None },
            key_stroke_ms: ms(b.key_stroke_s),
            hammer_before_key_bottom_ms: ms(b.hammer_ahead_s),
            hammer_speed_m_per_s: b.hammer_speed_m_per_s,
            key_speed_m_per_s: b.key_speed_m_per_s,
            string_contact_ms: ms(b.contact_s),
        };
        Report {
            instrument: &validation.instrument,
            predicted: all(|group| group.predicted),
            set: all(|group| group.set),
            groups,
            met: count(&[MET]),
            missed: count(&[MISSED, ABSENT]),
            undecided: 0,
            silent: count(&[SILENT]),
            open: count(&[OPEN]),
            constant_force: validation.constant_force.iter().map(press).collect(),
            pressed: validation.pressed.iter().map(press).collect(),
            grands: validation.grands.iter().map(Into::into).collect(),
            rows,
        }
    }
}

impl Report<'_> {
    /// Gives rows their bands; a row whose band is wider than what was published is neither met nor missed.
    fn take_bands(&mut self, bands: &[BandRow], published: &Published) {
        for ((report, band), row) in self.rows.iter_mut().zip(bands).zip(&published.rows) {
            (report.band_low, report.band_high) = (band.low, band.high);
            let known = band.low.zip(band.high).filter(|_| [MET, MISSED].contains(&report.verdict));
            if !known.is_some_and(|(low, high)| row.is_undecided([low, high])) {
                continue;
            }
            let was_met = report.verdict == MET;
            (report.verdict, report.missed_by) = (UNDECIDED, None);
            report.likely_reason = Some(WIDE);
            self.undecided += 1;
            let group = self.groups.iter_mut().find(|group| group.name == report.group);
            let is_set = report.set_by.is_some();
            let tallies = group.map(|group| {
                group.undecided += 1;
                if is_set { &mut group.set } else { &mut group.predicted }
            });
            let all = if is_set { &mut self.set } else { &mut self.predicted };
            for tally in tallies.into_iter().chain([all]) {
                tally.judged -= 1;
                tally.met -= usize::from(was_met);
            }
            if was_met { self.met -= 1 } else { self.missed -= 1 }
        }
    }

    /// Groups whose predicted rows are all met.
    fn whole_groups(&self) -> usize {
        let whole = |group: &&GroupReport| group.predicted.judged > 0 && group.predicted.met == group.predicted.judged;
        self.groups.iter().filter(whole).count()
    }
}

const MET: &str = "met";
const MISSED: &str = "missed";
const ABSENT: &str = "did not happen";
const UNDECIDED: &str = "cannot tell";
const SILENT: &str = "not modelled";
const OPEN: &str = "nothing published";

impl<'a> RowReport<'a> {
    fn new(row: &'a PublishedRow, verdict: Verdict, constant_force: Option<f64>, published: &'a Published) -> Self {
        let skipped = if let Verdict::Skipped(skipped) = verdict { Some(skipped.reason()) } else { None };
        let z = row.z(&verdict);
        let (verdict, simulated, missed_by) = match verdict {
            Verdict::Met { simulated } => (MET, Some(simulated), None),
            Verdict::Missed { simulated, by } => (MISSED, Some(simulated), Some(by)),
            Verdict::Absent => (ABSENT, None, None),
            Verdict::Open { simulated } => (OPEN, Some(simulated), None),
            Verdict::Silent | Verdict::Skipped(_) => (SILENT, None, None),
        };
        RowReport {
            name: &row.name,
            quantity: &row.quantity,
            group: &row.group,
            kind: row.kind.name(),
            set_by: row.set_by.as_deref(),
            unit: &row.unit,
            published: row.range(),
            at_least: row.at_least,
            at_most: row.at_most,
            simulated,
            band_low: None,
            band_high: None,
            verdict,
            missed_by,
            z,
            source: &row.source,
            source_title: published.sources.get(&row.source).map_or("", |source| &source.title),
            certainty: row.certainty,
            how: &row.how,
            likely_reason: if verdict == MET { None } else { skipped.or(row.if_missed.as_deref()) },
            constant_force,
        }
    }

    /// The range that counts, with its unit.
    fn counts(&self) -> String {
        let range = match (self.at_least, self.at_most) {
            (Some(low), Some(high)) => format!("{low} to {high}"),
            (Some(low), None) => format!("from {low}"),
            (None, Some(high)) => format!("to {high}"),
            (None, None) => return String::new(),
        };
        format!("{range} {}", self.unit).trim_end().to_owned()
    }
}

/// Why a row cannot be told.
const WIDE: &str = "the band over random grands is wider than the published range: numbers of the instrument must be known better first";

impl Validate {
    /// The simulated values of all rows with their bands.
    fn banded(
        &self,
        session: &mut Session,
        published: &Published,
        own: &Validation,
        keyboard: Option<&Keyboard>,
        count: u32,
    ) -> Result<Banded, Failure> {
        let names: Vec<bands::NameAndUnit> =
            published.rows.iter().map(|row| (row.name.clone(), row.unit.clone())).collect();
        let simulated =
            |validation: &Validation| validation.verdicts.iter().map(Verdict::simulated).collect::<Vec<_>>();
        let kept = format!("{published:?}{}", keyboard.map_or("", Keyboard::base_text));
        let kept = Some(("validated", kept.as_str()));
        bands::bands(session, &self.instrument, count, &names, &simulated(own), kept, |instrument, text, progress| {
            let keyboard = keyboard.and_then(|keyboard| keyboard.around(text.to_owned()).ok());
            let found = validate(instrument, keyboard.as_ref(), published, progress);
            Ok(unless_interrupted(found)?.map(|found| simulated(&found)).into())
        })
    }
}

/// Rows met of rows judged, by group.
fn print_groups(session: &mut Session, groups: &[GroupReport]) {
    let share =
        |tally: TallyReport| if tally.judged == 0 { "-".into() } else { format!("{}/{}", tally.met, tally.judged) };
    let banded = groups.iter().any(|group| group.undecided > 0);
    let cells = groups.iter().map(|group| {
        let z = |z: Option<f64>| z.map_or_else(|| "-".into(), |z| format!("{z:.2}"));
        let undecided = banded.then(|| group.undecided.to_string());
        [group.title.clone(), share(group.predicted), z(group.z), share(group.set), z(group.z_set)]
            .into_iter()
            .chain(undecided)
    });
    let undecided = banded.then_some("cannot tell");
    print_line!(session, "{}", Table::of(["", "predicted", "z", "set", "z"].into_iter().chain(undecided), cells));
}

/// Timing beside three grands, at every level.
fn print_grands(session: &mut Session, levels: &[GrandsReport]) {
    let Some(first) = levels.first() else { return };
    let names: Vec<&str> = first.grands.iter().map(|one| one.grand).collect();
    let one = |ms: Option<f64>| ms.map_or_else(|| "-".into(), |ms| format!("{ms:.1}"));
    let all = |level: &GrandsReport, get: fn(&GrandReport) -> f64, decimals: usize| {
        level.grands.iter().map(|grand| format!("{:.decimals$}", get(grand))).collect::<Vec<_>>().join("/")
    };
    let cells = levels.iter().map(|level| {
        [
            format!("{} {}", level.touch, level.hammer_speed_m_per_s),
            one(level.travel_of_hand_ms),
            one(level.travel_ms),
            all(level, |grand| grand.travel_ms, 0),
            one(level.key_bottom_ms),
            all(level, |grand| grand.key_bottom_ms, 1),
            one(level.off_knuckle_ms),
            one(level.free_flight_ms),
            all(level, |grand| grand.free_flight_ms, 1),
        ]
    });
    print_line!(session, "  Timing in ms by the hammer's speed in m/s, beside {}:", names.join(" / "));
    let heads = ["", "from hand", "travel", "grands", "key bottom", "grands", "off knuckle", "free flight", "grands"];
    print_line!(session, "{}", Table::of(heads, cells));
}

fn print_table(session: &mut Session, rows: &[RowReport]) {
    let banded = rows.iter().any(|row| row.band_low.is_some());
    let heads = ["", "met if", "simulated", "5 to 95 %", "verdict"];
    let mut group = rows.first().map_or("", |row| row.group);
    let mut cells: Vec<[String; 5]> = Vec::new();
    for row in rows {
        if row.group != group {
            cells.push(Default::default());
            group = row.group;
        }
        let by = row.missed_by.map_or_else(String::new, |by| {
            let sign = if by < 0.0 { "-" } else { "+" };
            format!(" by {sign}{} {}", three(by.abs()), row.unit).trim_end().to_owned()
        });
        let set = if row.set_by.is_some() { ", set" } else { "" };
        let simulated = row.simulated.map_or_else(|| "-".to_owned(), three);
        let band = row.band_low.zip(row.band_high);
        let band = band.map_or_else(String::new, |(low, high)| format!("{} to {}", three(low), three(high)));
        let verdict = format!("{}{by}{set}", row.verdict);
        cells.push([row.quantity.to_owned(), row.counts(), simulated, band, verdict]);
        if let Some(x) = row.constant_force {
            let [none, empty] = [const { String::new() }; 2];
            cells.push(["  under a constant force".to_owned(), none, three(x), empty, "not counted".to_owned()]);
        }
    }
    let shown = |column: &usize| banded || heads[*column] != "5 to 95 %";
    let of = |row: &[String; 5]| (0..5).filter(shown).map(|column| row[column].clone()).collect::<Vec<_>>();
    print_line!(session, "{}", Table::of((0..5).filter(shown).map(|column| heads[column]), cells.iter().map(of)));
    print_line!(session, "  The published values, and the source of each, are in validate.csv.");
    print_line!(session);
    // Rows with one reason share a line.
    let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
    for row in rows.iter().filter(|row| row.verdict != MET) {
        let reason = row.likely_reason.unwrap_or("no reason is known");
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, quantities)) => quantities.push(row.quantity),
            None => reasons.push((reason, vec![row.quantity])),
        }
    }
    for (reason, quantities) in reasons {
        print_line!(session, "  {}: {reason}", quantities.join("; "));
    }
    print_line!(session);
}

/// Hammer speeds that the figure names, m/s, and their marks: equal ratios from pp, 0.5, to ff, 5.
const MARKS: [(f64, &str); 6] = [(0.5, "pp"), (0.79, "p"), (1.26, "mp"), (1.99, "mf"), (3.15, "f"), (5.0, "ff")];

/// Half the width of a bar, m/s.
const BAR_M_PER_S: f64 = 0.12;

/// A published value with its range, drawn as a bar at a hammer speed.
struct Bar {
    x: [f64; 2],
    y: [f64; 2],
    range: [[f64; 2]; 2],
}

/// Presses that sound, and what they show against the hammer's speed; what did not happen is a gap.
struct Curve<'a> {
    presses: Vec<&'a SimulatedPress>,
    speeds: Vec<f64>,
    ahead_ms: Vec<f64>,
    stroke_ms: Vec<f64>,
}

impl<'a> Curve<'a> {
    fn of(presses: impl Iterator<Item = &'a SimulatedPress>) -> Self {
        let presses: Vec<&SimulatedPress> = presses.collect();
        let ms = |get: fn(&SimulatedPress) -> Option<f64>| -> Vec<f64> {
            presses.iter().map(|b| get(b).map_or(f64::NAN, |s| 1e3 * s)).collect()
        };
        Curve {
            speeds: presses.iter().filter_map(|b| b.hammer_speed_m_per_s).collect(),
            ahead_ms: ms(|b| b.hammer_ahead_s),
            stroke_ms: ms(|b| b.key_stroke_s),
            presses,
        }
    }

    /// The hammer speed of the first press of which something holds.
    fn speed(&self, holds: impl Fn(&SimulatedPress) -> bool) -> Option<f64> {
        self.presses.iter().find(|b| holds(b)).and_then(|b| b.hammer_speed_m_per_s)
    }
}

/// The order of events against loudness: simulated presses, and the published points as bars.
fn order_picture(validation: &Validation, published: &Published) -> Picture {
    let [constant, pressed] = [&validation.constant_force, &validation.pressed]
        .map(|presses| Curve::of(presses.iter().filter(|b| b.hammer_speed_m_per_s.is_some())));
    // Where a row's published number stands: at the hammer speed of the simulated press that it was compared with.
    let bar = |name: &str, speed: Option<f64>| -> Option<Bar> {
        let row = published.rows.iter().find(|row| row.name == name)?;
        let v = speed?;
        let (number, low, high) = (row.number?, row.at_least?, row.at_most?);
        Some(Bar { x: [v - BAR_M_PER_S, v + BAR_M_PER_S], y: [number, number], range: [[v, v], [low, high]] })
    };
    let near = |force: f64| constant.speed(|b| matches!(b.drive, Drive::Constant(n) if n >= force));
    let quick = |b: &SimulatedPress| b.key_stroke_s.is_some_and(|t| t <= 0.025);
    let bars = |all: [Option<Bar>; 5]| -> Vec<Bar> { all.into_iter().flatten().collect() };
    let orders = bars([
        bar("hammer_ahead_pp", Some(0.5)),
        bar("hammer_ahead_p", near(0.8)),
        bar("hammer_ahead_f", pressed.speed(quick)),
        bar("hammer_ahead_ff", Some(5.0)),
        bar("hammer_ahead_loudest", pressed.presses.last().and_then(|b| b.hammer_speed_m_per_s)),
    ]);
    let strokes = bars([
        bar("key_stroke_at_0_8_N", near(0.8)),
        bar("key_stroke_f", Some(3.15)),
        bar("key_stroke_ff", Some(5.0)),
        bar("key_stroke_at_15_N", near(15.0)),
        None,
    ]);
    let ahead = [&pressed, &constant].map(|c| (&c.speeds, &c.ahead_ms));
    let stroke = [&pressed, &constant].map(|c| (&c.speeds, &c.stroke_ms));
    let panels = vec![
        panel("hammer before key bottom", 280.0, ahead, &orders, true),
        panel("key start to key bottom", 180.0, stroke, &strokes, false),
    ];
    let fastest = pressed.speeds.iter().chain(&constant.speeds).copied().fold(5.0, f64::max);
    let title = format!("{}: order of events against loudness", validation.instrument);
    let subtitle = "a hand whose force rises, and constant forces; bars: published, with the range that counts as met";
    let over = "hammer speed at the string (m/s)";
    figure_picture(&Figure {
        markers: MARKS.iter().map(|(x, label)| Marker { x: *x, label: (*label).into() }).collect(),
        ..Figure::over(over, (0.0, 1.08 * fastest), title, subtitle.into(), panels)
    })
}

/// Abscissae of the line at zero.
const EVERYWHERE: [f64; 2] = [0.0, 100.0];

fn panel<'a>(
    quantity: &str,
    height_px: f64,
    [pressed, constant]: [(&'a Vec<f64>, &'a Vec<f64>); 2],
    bars: &'a [Bar],
    zero: bool,
) -> Panel<'a> {
    let mut curves = vec![
        Trace::new("pressed by a hand", pressed.0, pressed.1, 0, Dash::Solid),
        Trace::new("constant force", constant.0, constant.1, 3, Dash::Dashed),
    ];
    for (index, bar) in bars.iter().enumerate() {
        let [published, met] = if index == 0 { ["published", "counts as met"] } else { [""; 2] };
        curves.push(Trace::new(published, &bar.x, &bar.y[..], 1, Dash::Solid));
        curves.push(Trace::new(met, &bar.range[0], &bar.range[1][..], 5, Dash::Solid));
    }
    if zero {
        curves.push(Trace::new("together", &EVERYWHERE, &[0.0; 2][..], 6, Dash::Dotted));
    }
    Panel::new(quantity, "ms", height_px, curves)
}
