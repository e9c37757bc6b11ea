//! Assignment of a table's columns to time, force and position, and their units.
//!
//! A title gives both (`force_N`, `Displacement (mm)`, `F [gf]`, `t / ms`), or a [`Columns`] names them.

use std::str::FromStr;

use super::rows::{Place, excerpt};
use crate::parameter::{Quantity, Unit};

use super::{MAX_FORCE_N, MAX_POSITION_M, StrokeError};

/// Quantity of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Seconds.
    Time,
    /// The finger's force on the key, pushing positive.
    Force,
    /// Position of the key's front or of the fingertip, down positive.
    Position,
    /// Rise of the hammer's strike point, up positive.
    HammerHead,
    /// Speed of the hammer's strike point, up positive.
    HammerSpeed,
}

/// All roles, in the order in which they are read and shown.
pub const ROLES: [Role; 5] = [Role::Time, Role::Force, Role::Position, Role::HammerHead, Role::HammerSpeed];

/// Largest time, s: a day. A larger number is milliseconds, or a calendar.
const MAX_TIME_S: f64 = 86_400.0;

const TIMES: &[&str] = &["time", "t", "zeit", "temps"];
const FORCES: &[&str] = &["force", "f", "load", "finger_force", "key_force"];
/// Among these, `key` counts only with a unit: without one it may be a key's number.
const POSITIONS: &[&str] = &[
    "key",
    "position",
    "pos",
    "travel",
    "displacement",
    "depth",
    "dip",
    "key_position",
    "key_travel",
    "key_displacement",
    "key_depth",
    "key_dip",
];
const FINGERTIPS: &[&str] = &[
    "finger_position",
    "finger_travel",
    "finger_displacement",
    "fingertip",
    "fingertip_position",
    "fingertip_travel",
    "fingertip_displacement",
];
const HAMMERS: &[&str] =
    &["hammer_rise", "hammer_head", "hammer_head_position", "hammer_head_travel", "hammer_head_displacement"];
const HAMMER_SPEEDS: &[&str] = &["hammer_head_speed", "hammer_head_velocity", "hammer_speed", "hammer_velocity"];
/// Longest beginning of a title, bytes, that is compared with these stems: a title may be as long as a line.
const LONGEST_STEM: usize = 64;
/// The largest plausible speed, m/s: hammers reach 10.
const MAX_SPEED_M_PER_S: f64 = 100.0;

impl Role {
    /// Name of the role in [`Columns`].
    pub fn name(self) -> &'static str {
        match self {
            Role::Time => "time",
            Role::Force => "force",
            Role::Position => "position",
            Role::HammerHead => "hammer",
            Role::HammerSpeed => "hammer_speed",
        }
    }

    /// The title that this project writes.
    pub fn title(self) -> &'static str {
        match self {
            Role::Time => "time_s",
            Role::Force => "force_N",
            Role::Position => "position_m",
            Role::HammerHead => "hammer_rise_m",
            Role::HammerSpeed => "hammer_rise_m_per_s",
        }
    }

    /// Physical quantity of the role.
    pub fn quantity(self) -> Quantity {
        match self {
            Role::Time => Quantity::Time,
            Role::Force => Quantity::Force,
            Role::Position | Role::HammerHead => Quantity::Length,
            Role::HammerSpeed => Quantity::Speed,
        }
    }

    /// The largest plausible number, SI, and the expected text for a larger one.
    pub(super) fn largest(self) -> (f64, &'static str) {
        match self {
            Role::Time => (MAX_TIME_S, "seconds from the start of the stroke, at most 86400 (milliseconds?)"),
            Role::Force => (MAX_FORCE_N, "newtons, at most 10000 (another unit?)"),
            Role::Position | Role::HammerHead => (MAX_POSITION_M, "metres, at most 1 (millimetres?)"),
            Role::HammerSpeed => (MAX_SPEED_M_PER_S, "metres per second, at most 100 (another unit?)"),
        }
    }

    fn is_stem(self, stem: &str) -> bool {
        match self {
            Role::Time => TIMES.contains(&stem),
            Role::Force => FORCES.contains(&stem),
            Role::Position => POSITIONS.contains(&stem) || FINGERTIPS.contains(&stem),
            Role::HammerHead => HAMMERS.contains(&stem),
            Role::HammerSpeed => HAMMER_SPEEDS.contains(&stem),
        }
    }

    /// Example of a title with a unit.
    fn example(self) -> &'static str {
        match self {
            Role::Time => "`time_s` or `time (ms)`",
            Role::Force => "`force_N` or `force (gf)`",
            Role::Position => "`position_m` or `position (mm)`",
            Role::HammerHead => "`hammer_rise_m` or `hammer_rise (mm)`",
            Role::HammerSpeed => "`hammer_rise_m_per_s` or `hammer_speed (m/s)`",
        }
    }
}

/// Body to which a stroke's position belongs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PositionOf {
    /// The key's front.
    #[default]
    Key,
    /// The fingertip's, on the driver's side of its softness.
    Fingertip,
    /// The key's, by a sensor behind the balance pin that was calibrated at the front: what the front would be if the
    /// key did not bend.
    KeyBack,
}

impl PositionOf {
    /// Its name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            PositionOf::Key => "key",
            PositionOf::Fingertip => "fingertip",
            PositionOf::KeyBack => "key-back",
        }
    }
}

/// A title split into what it names and the unit that it states.
#[derive(Debug, PartialEq)]
struct Title {
    /// Words, small, with `_` between them.
    stem: String,
    /// The unit as it is written.
    unit: Option<String>,
    /// Whether the unit stands apart, in brackets or after a stroke, so that it can be nothing else.
    apart: bool,
}

fn words(text: &str) -> String {
    let text = text.to_lowercase();
    text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect::<Vec<_>>().join("_")
}

impl Title {
    /// `Force (gf)`, `force_gf`, `Force gf`, `F / gf`, `forcegf`.
    fn read(title: &str, role: Role) -> Self {
        let title = title.trim().trim_end_matches('.');
        for (open, close) in [('(', ')'), ('[', ']'), ('{', '}'), ('<', '>')] {
            if let Some((before, unit)) = title.strip_suffix(close).and_then(|t| t.rsplit_once(open)) {
                return Title { stem: words(before), unit: Some(unit.trim().to_owned()), apart: true };
            }
        }
        // `hammer_rise_m_per_s`, `hammer speed m/s`: a unit of several words.
        if role.quantity() == Quantity::Speed
            && let Some(unit) = ["mm_per_s", "cm_per_s", "m_per_s", "mm/s", "cm/s", "m/s"]
                .into_iter()
                .find(|unit| title.strip_suffix(unit).is_some_and(|t| !t.ends_with(char::is_alphanumeric)))
        {
            let stem = words(&title[..title.len() - unit.len()]);
            // With such a unit it is no rise.
            let stem = if ["hammer_rise", "hammer_head"].contains(&stem.as_str()) {
                "hammer_head_speed".to_owned()
            } else {
                stem
            };
            return Title { stem, unit: Some(unit.to_owned()), apart: true };
        }
        if let Some((before, unit)) = title.rsplit_once('/')
            && role.quantity().unit(unit).is_some()
        {
            return Title { stem: words(before), unit: Some(unit.trim().to_owned()), apart: true };
        }
        let stem = words(title);
        if let Some(at) = title.rfind(|c: char| !c.is_alphanumeric()) {
            let unit = title[at..].trim_start_matches(|c: char| !c.is_alphanumeric());
            if role.quantity().unit(unit).is_some() && at > 0 {
                return Title { stem: words(&title[..at]), unit: Some(unit.to_owned()), apart: false };
            }
        }
        // Nothing between them, as in `forceN`; a stem of one letter says nothing then.
        let cut = (3..title.len().min(LONGEST_STEM)).filter(|&at| title.is_char_boundary(at)).find(|&at| {
            role.is_stem(&words(&title[..at]))
                && title[at..].chars().all(char::is_alphanumeric)
                // `times` is a plural.
                && &title[at..] != "s"
                && role.quantity().unit(&title[at..]).is_some()
        });
        match cut {
            Some(at) => Title { stem: words(&title[..at]), unit: Some(title[at..].to_owned()), apart: false },
            None => Title { stem, unit: None, apart: false },
        }
    }
}

/// A column that was asked for by its title or number, and perhaps its unit.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Asked {
    /// Do not read this quantity.
    None,
    /// Title, and after a colon the unit.
    Named(String),
}

/// Columns to read, for files whose titles do not name them.
///
/// As text: `time=Time (s),position=Displacement (mm),force=F [gf]`. The names are `time`, `force`, `position`,
/// `hammer` and `hammer_speed`; what follows is the column's title up to the next name, or `#3` for the third column. A
/// unit after a colon is the one that a title does not state: `position=x:mm`. `none` reads no such column.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Columns {
    asked: [Option<Asked>; ROLES.len()],
}

/// A fault in such a text.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}; expected as in `time=Time (s),position=Displacement (mm),force=F [gf]`")]
pub struct ColumnsError(String);

impl FromStr for Columns {
    type Err = ColumnsError;

    fn from_str(text: &str) -> Result<Self, ColumnsError> {
        let mut columns = Columns::default();
        let mut rest = text;
        while !rest.trim().is_empty() {
            let (role, after) = role_of(rest).ok_or_else(|| {
                ColumnsError(format!(
                    "found {}; expected time=, force=, position=, hammer= or hammer_speed= in front of a title",
                    excerpt(rest)
                ))
            })?;
            // A title may hold commas: it ends where the next name begins.
            let end = after.match_indices(',').map(|(at, _)| at).find(|&at| role_of(&after[at + 1..]).is_some());
            let (title, next) = end.map_or((after, ""), |at| (&after[..at], &after[at + 1..]));
            rest = next;
            let title = title.trim();
            let unquoted = title.strip_prefix('"').and_then(|t| t.rsplit_once('"'));
            let title = match unquoted {
                Some((inner, "")) => inner.to_owned(),
                Some((inner, unit)) if unit.starts_with(':') => format!("{inner}{unit}"),
                _ => title.to_owned(),
            };
            if title.is_empty() {
                return Err(ColumnsError(format!("`{}=` lacks a title", role.name())));
            }
            let place = &mut columns.asked[role as usize];
            if place.is_some() {
                return Err(ColumnsError(format!("`{}=` stands there twice", role.name())));
            }
            *place = Some(if title == "none" { Asked::None } else { Asked::Named(title) });
        }
        if columns.asked[Role::Time as usize] == Some(Asked::None) {
            return Err(ColumnsError("the file has no time column".into()));
        }
        if columns == Columns::default() {
            return Err(ColumnsError("no column is named".into()));
        }
        Ok(columns)
    }
}

/// The role that a text begins with, as in `force=`, and what follows.
fn role_of(text: &str) -> Option<(Role, &str)> {
    let (name, rest) = text.split_once('=')?;
    let name = name.trim().to_lowercase();
    ROLES.into_iter().find(|role| role.name() == name || role.title() == name).map(|role| (role, rest))
}

impl Columns {
    /// Whether a title is requested by its name: then the header may follow other lines.
    pub(super) fn name_titles(&self) -> bool {
        self.asked.iter().flatten().any(|asked| matches!(asked, Asked::Named(title) if !title.starts_with('#')))
    }

    /// Whether all columns are requested by number: then there may be no header.
    pub(super) fn need_no_titles(&self) -> bool {
        let named: Vec<&Asked> = self.asked.iter().flatten().collect();
        !named.is_empty()
            && self.asked[0].is_some()
            && named
                .iter()
                .all(|asked| matches!(asked, Asked::Named(title) if title.starts_with('#')) || **asked == Asked::None)
    }

    /// Whether all requested titles are among these.
    pub(super) fn are_among(&self, titles: &[&str]) -> bool {
        self.asked.iter().flatten().all(|asked| match asked {
            Asked::None => true,
            Asked::Named(title) => find_title(title, titles).is_some(),
        })
    }
}

/// A title among others: itself, else whatever its capitals, else `#3`; each also with a unit after a colon.
fn find_title<'a>(asked: &'a str, titles: &[&str]) -> Option<(usize, Option<&'a str>)> {
    let alone = |asked: &str| {
        let same = |other: &&str| other.trim() == asked;
        let similar = |other: &&str| other.trim().to_lowercase() == asked.to_lowercase();
        let number = asked.strip_prefix('#').and_then(|n| n.parse::<usize>().ok());
        let by_number = number.filter(|n| (1..=titles.len()).contains(n)).map(|n| n - 1);
        titles.iter().position(same).or_else(|| titles.iter().position(similar)).or(by_number)
    };
    alone(asked).map(|index| (index, None)).or_else(|| {
        let (title, unit) = asked.rsplit_once(':')?;
        alone(title.trim()).map(|index| (index, Some(unit.trim())))
    })
}

/// A column that is read.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Role of the column.
    pub role: Role,
    /// Number of the column, from 0.
    pub index: usize,
    /// Its title in the file.
    pub title: String,
    /// The unit's usual name; empty as long as it is not known.
    pub unit: &'static str,
    /// Value of the unit in SI.
    pub factor: f64,
}

/// The columns that are read of a table, time first, and at least one of force and position.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// The columns.
    pub columns: Vec<Column>,
    /// Whose position the column holds, as far as its title says.
    pub position_of: PositionOf,
    /// Titles of the columns that are not read, in their order.
    pub unused: Vec<String>,
}

impl Layout {
    /// Finds the columns by their titles in the file of this name.
    ///
    /// # Errors
    /// A column that is missing, is there twice, or states no unit or one that is not known.
    pub fn of(titles: &[&str], columns: &Columns, file: &str) -> Result<Self, Box<StrokeError>> {
        let place = Place { file: file.to_owned(), line: 0 };
        let layout = Self::find(titles, columns, &place)?;
        layout.check_units(&place)?;
        Ok(layout)
    }

    /// As [`Layout::of`], but units that no title states may come in the next row.
    pub(super) fn find(titles: &[&str], asked: &Columns, place: &Place) -> Result<Self, Box<StrokeError>> {
        let all = || excerpt(&titles.join(","));
        let mut columns = Vec::new();
        for role in ROLES {
            let column = match &asked.asked[role as usize] {
                Some(Asked::None) => None,
                Some(Asked::Named(title)) => Some(named(role, title, titles, place)?),
                None => by_title(role, titles, place)?,
            };
            columns.extend(column);
        }
        if columns.first().is_none_or(|column| column.role != Role::Time) {
            return Err(place.fault(Role::Time.title(), "this column is missing", all(), "a header with `time_s`"));
        }
        if !columns.iter().any(|column| matches!(column.role, Role::Force | Role::Position)) {
            let expected = "`force_N`, `position_m` or both beside `time_s`";
            return Err(place.fault(
                Role::Force.title(),
                "the file has neither a force nor a position column",
                all(),
                expected,
            ));
        }
        let fingertip = |column: &Column| {
            column.role == Role::Position
                && FINGERTIPS.contains(&Title::read(&column.title, Role::Position).stem.as_str())
        };
        let position_of = if columns.iter().any(fingertip) { PositionOf::Fingertip } else { PositionOf::Key };
        let used = |index: usize| columns.iter().any(|column| column.index == index);
        let unused = titles.iter().enumerate().filter(|&(index, title)| !used(index) && !title.trim().is_empty());
        let unused = unused.map(|(_, title)| title.trim().to_owned()).collect();
        Ok(Layout { columns, position_of, unused })
    }

    /// Takes the units that a row below the titles states; false where it is no such row.
    pub(super) fn take_units(&mut self, cells: &[&str]) -> bool {
        let unit = |column: &Column| {
            let cell = cells.get(column.index)?.trim();
            let bare =
                [('(', ')'), ('[', ']')].iter().find_map(|&(open, close)| cell.strip_prefix(open)?.strip_suffix(close));
            column.role.quantity().unit(bare.unwrap_or(cell))
        };
        let units: Option<Vec<_>> = self.columns.iter().map(unit).collect();
        let Some(units) = units else { return false };
        for (column, unit) in self.columns.iter_mut().zip(units) {
            (column.factor, column.unit) = (unit.si, unit.symbol);
        }
        true
    }

    /// No unit is guessed.
    pub(super) fn check_units(&self, place: &Place) -> Result<(), Box<StrokeError>> {
        match self.columns.iter().find(|column| column.unit.is_empty()) {
            None => Ok(()),
            Some(Column { role, title, .. }) => {
                let expected = format!("one of {} in its title, as in {}", role.quantity().known(), role.example());
                Err(place.fault(title, "a column without a unit", excerpt(title), expected))
            }
        }
    }
}

/// The column of a title that was asked for.
fn named(role: Role, asked: &str, titles: &[&str], place: &Place) -> Result<Column, Box<StrokeError>> {
    let Some((index, stated)) = find_title(asked, titles) else {
        let all = titles.iter().map(|title| format!("`{}`", title.trim())).collect::<Vec<_>>().join(", ");
        let expected = format!("one of {}", excerpt_of(&all));
        return Err(place.fault(role.name(), "no column has this title", excerpt(asked), expected));
    };
    let title = titles[index].trim().to_owned();
    if titles.iter().filter(|other| other.trim() == title).count() > 1 && !asked.starts_with('#') {
        return Err(place.fault(
            &title,
            "there are two columns of this name",
            excerpt(&titles.join(",")),
            "one, or its number as in `#2`",
        ));
    }
    let read = Title::read(&title, role);
    let unit = stated.or(read.unit.as_deref());
    let (factor, name) = match unit {
        None => (1.0, ""),
        Some(unit) => match role.quantity().unit(unit) {
            Some(unit) => (unit.si, unit.symbol),
            None => return Err(unknown_unit(role, &title, unit, place)),
        },
    };
    Ok(Column { role, index, title, unit: name, factor })
}

fn unknown_unit(role: Role, title: &str, unit: &str, place: &Place) -> Box<StrokeError> {
    let expected = format!("one of {}", role.quantity().known());
    place.fault(title, "not a unit that is known here", excerpt(unit), expected)
}

/// Not quite as short as an excerpt.
fn excerpt_of(text: &str) -> String {
    let mut short: String = text.chars().filter(|c| !c.is_control()).take(300).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
}

/// The column whose title says that it is the one.
fn by_title(role: Role, titles: &[&str], place: &Place) -> Result<Option<Column>, Box<StrokeError>> {
    let all = || excerpt(&titles.join(","));
    let exact: Vec<usize> = (0..titles.len()).filter(|&index| titles[index] == role.title()).collect();
    let column = |index: usize, unit: Option<&Unit>| {
        let (factor, unit) = unit.map_or((1.0, ""), |unit| (unit.si, unit.symbol));
        Column { role, index, title: titles[index].to_owned(), unit, factor }
    };
    match exact[..] {
        [index] => return Ok(Some(column(index, role.quantity().units().first()))),
        [] => {}
        _ => return Err(place.fault(role.title(), "there are two columns of this name", all(), "one")),
    }
    let mut with_unit = Vec::new();
    let mut without = None;
    let mut unknown = None;
    for (index, title) in titles.iter().enumerate() {
        let read = Title::read(title, role);
        if !role.is_stem(&read.stem) {
            continue;
        }
        match read.unit.as_deref().map(|unit| (unit, role.quantity().unit(unit))) {
            Some((_, Some(unit))) => with_unit.push(column(index, Some(unit))),
            // To ignore it would be a trap.
            Some((unit, None)) if read.apart => unknown = unknown.or(Some((index, unit.to_owned()))),
            _ if read.stem == "key" => {}
            _ => without = without.or(Some(column(index, None))),
        }
    }
    match (with_unit.len(), without, unknown) {
        (1, ..) => Ok(with_unit.pop()),
        (0, Some(column), _) => Ok(Some(column)),
        (0, None, Some((index, unit))) => Err(unknown_unit(role, titles[index], &unit, place)),
        (0, None, None) => Ok(None),
        _ => {
            let several = with_unit.iter().map(|column| column.title.as_str()).collect::<Vec<_>>().join(",");
            let message = format!("several columns could be the {}", role.name());
            Err(place.fault(role.title(), message, excerpt(&several), "one, or a choice of columns"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(titles: &[&str], asked: &str) -> Result<Vec<(usize, &'static str)>, String> {
        let columns = if asked.is_empty() {
            Columns::default()
        } else {
            asked.parse().map_err(|e: ColumnsError| e.to_string())?
        };
        let layout = Layout::of(titles, &columns, "t.csv").map_err(|error| error.to_string())?;
        Ok(layout.columns.iter().map(|column| (column.index, column.unit)).collect())
    }

    #[test]
    fn titles_state_their_units() {
        for (titles, want) in [
            (["time_s", "force_N"], ["s", "N"]),
            (["Time (s)", "F [gf]"], ["s", "gf"]),
            (["t / ms", "Load (lbf)"], ["ms", "lbf"]),
            (["Time [\u{b5}s]", "Displacement (mm)"], ["us", "mm"]),
            (["TIME_S", "positionmm"], ["s", "mm"]),
            (["Time sec.", "Key travel [in]"], ["s", "in"]),
            (["time_s", "key_m"], ["s", "m"]),
        ] {
            assert_eq!(found(&titles, ""), Ok(vec![(0, want[0]), (1, want[1])]), "{titles:?}");
        }
        for (title, unit) in [
            ("hammer_rise_m_per_s", "m/s"),
            ("hammer_head_mm_per_s", "mm/s"),
            ("Hammer speed (m/s)", "m/s"),
            ("hammer velocity mm/s", "mm/s"),
            ("hammer_speed_m_per_s", "m/s"),
            ("Hammer speed [cm/s]", "cm/s"),
        ] {
            assert_eq!(found(&["time_s", "force_N", title], ""), Ok(vec![(0, "s"), (1, "N"), (2, unit)]), "{title}");
        }
        assert!(found(&["time_s", "force_N", "hammer speed (mm)"], "").unwrap_err().contains("m/s, cm/s, mm/s"));
        let both = ["time_s", "force_N", "hammer_rise_m", "hammer_rise_m_per_s"];
        assert_eq!(found(&both, ""), Ok(vec![(0, "s"), (1, "N"), (2, "m"), (3, "m/s")]));
        let own = ["time_s", "force_N", "key_m", "hammer_rise_m", "key_rad", "hammer_rad", "tail_m", "key"];
        assert_eq!(found(&own, ""), Ok(vec![(0, "s"), (1, "N"), (2, "m"), (3, "m")]));
    }

    #[test]
    fn titles_are_chosen() {
        let titles = ["Laser, left (V)", "t", "x", "Time (s)", "Displacement (mm)", "F [gf]"];
        assert_eq!(
            found(&titles, "time=Time (s),position=Displacement (mm),force=F [gf]"),
            Ok(vec![(3, "s"), (5, "gf"), (4, "mm")])
        );
        assert_eq!(found(&titles, "time=\"t\":ms,position=x:um,force=none"), Ok(vec![(1, "ms"), (2, "um")]));
        assert_eq!(found(&titles, "time=time (S), position=#3:mm, force=none"), Ok(vec![(3, "s"), (2, "mm")]));
        assert_eq!(found(&titles, "position=Laser, left (V):mm,time=#2:s,force=none"), Ok(vec![(1, "s"), (0, "mm")]));
    }

    #[test]
    fn what_is_wrong_is_told() {
        let titles = ["Time (s)", "Force (V)", "x"];
        for (asked, parts) in [
            ("", &["Force (V)", "not a unit", "`V`", "N, mN, cN"][..]),
            ("force=Force (V)", &["not a unit", "`V`", "lbf"]),
            ("force=none,position=x", &["without a unit", "`x`", "mm"]),
            ("force=none,position=x:furlong", &["not a unit", "`furlong`", "m, dm"]),
            ("force=none,position=y", &["no column has this title", "`y`", "`Force (V)`"]),
            ("force=none,position=none", &["neither"]),
            ("time=none", &["no time column"]),
            ("weight=x", &["in front of a title", "Displacement (mm)"]),
            ("force=", &["lacks a title"]),
            ("force=x,force=x", &["twice"]),
        ] {
            let said = found(&titles, asked).unwrap_err();
            assert!(parts.iter().all(|part| said.contains(part)), "{asked}: {said}");
        }
        let said = found(&["time_s", "Force (N)", "load_gf"], "").unwrap_err();
        assert!(said.contains("several columns could be the force") && said.contains("load_gf"), "{said}");
    }

    #[test]
    fn whose_position() {
        let of = |title: &str| Layout::of(&["time_s", title], &Columns::default(), "").unwrap().position_of;
        assert_eq!(of("position_m"), PositionOf::Key);
        assert_eq!(of("key_m"), PositionOf::Key);
        assert_eq!(of("Finger travel (mm)"), PositionOf::Fingertip);
    }
}
