//! Lines of the sheet: labels, units and the digits that a technician reads. Their usual ranges are in
//! [`super::usual`].

use std::sync::LazyLock;

use serde::{Deserialize, Deserializer};

use super::entries::{Flag, Sheet};
use super::usual::{UsualRange, usual};
use crate::digits::plain;
use erard::instrument::Instrument;
use erard::instrument::from_toml::from_toml;
use erard::keyboard::note_name;

/// Key of the norms of an instrument that does not know its key: middle C.
pub const MIDDLE_C: usize = 40;

/// Key whose norms hold for an instrument: its own, or middle C where it does not know its key.
#[must_use]
pub fn norms_key(instrument: &Instrument) -> usize {
    instrument.key().unwrap_or(MIDDLE_C)
}

/// Text that is read once and kept as long as the program runs.
pub(crate) type Kept = &'static str;

/// Line of the sheet.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// Key in `measure.json`.
    #[serde(deserialize_with = "kept")]
    pub key: Kept,
    /// Label of the line.
    #[serde(deserialize_with = "kept")]
    pub label: Kept,
    /// Unit; empty for a ratio.
    #[serde(default, deserialize_with = "kept")]
    pub unit: Kept,
    /// Significant decimals.
    pub decimals: usize,
    /// Whether no page shows the line: only callers that name it get it.
    #[serde(default)]
    pub on_request: bool,
    /// Function that returns the line's value from a sheet.
    #[serde(skip, default = "no_value")]
    pub value: fn(&Sheet) -> Option<f64>,
}

fn kept<'de, D: Deserializer<'de>>(file: D) -> Result<Kept, D::Error> {
    String::deserialize(file).map(|text| &*text.leak())
}

fn no_value() -> fn(&Sheet) -> Option<f64> {
    |_| None
}

/// Lines that belong together.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// Heading of the group.
    #[serde(deserialize_with = "kept")]
    pub heading: Kept,
    /// Lines of the group.
    #[serde(rename = "line")]
    pub lines: Vec<Line>,
}

type Value = (&'static str, fn(&Sheet) -> Option<f64>);

/// Values of the lines in a sheet.
const VALUES: [Value; 47] = [
    ("down_weight_g", |s| s.down_weight_g),
    ("up_weight_g", |s| s.up_weight_g),
    ("balance_weight_g", |s| s.balance_weight_g),
    ("friction_weight_g", |s| s.friction_weight_g),
    ("dampers_down.down_weight_g", |s| s.dampers_down?.down_weight_g),
    ("dampers_down.up_weight_g", |s| s.dampers_down?.up_weight_g),
    ("dampers_down.friction_weight_g", |s| s.dampers_down?.friction_weight_g),
    ("by_slow_loop.down_weight_g", |s| s.by_slow_loop.down_weight_g),
    ("by_slow_loop.up_weight_g", |s| s.by_slow_loop.up_weight_g),
    ("front_weight_g", |s| Some(s.front_weight_g)),
    ("strike_weight_g", |s| Some(s.strike_weight_g)),
    ("whippen_weight_g", |s| Some(s.whippen_weight_g)),
    ("key_ratio", |s| Some(s.key_ratio)),
    ("friction_in_balance_g", |s| s.friction_in_balance_g),
    ("strike_weight_ratio_weights", |s| s.strike_weight_ratio_weights),
    ("strike_weight_ratio_weights_half_way", |s| s.strike_weight_ratio_weights_half_way),
    ("strike_weight_ratio_kinematics_at_rest", |s| Some(s.strike_weight_ratio_kinematics_at_rest)),
    ("strike_weight_ratio_kinematics_half_way", |s| Some(s.strike_weight_ratio_kinematics_half_way)),
    ("strike_weight_ratio_kinematics_at_let_off", |s| Some(s.strike_weight_ratio_kinematics_at_let_off)),
    ("strike_weight_ratio_kinematics", |s| Some(s.strike_weight_ratio_kinematics)),
    ("dip_mm", |s| s.dip_mm),
    ("blow_mm", |s| s.blow_mm),
    ("lost_motion_mm", |s| s.lost_motion_mm),
    ("jack_position_mm", |s| s.jack_position_mm),
    ("lever_height_mm", |s| s.lever_height_mm),
    ("let_off_begins_mm", |s| s.let_off_begins_mm),
    ("let_off_mm", |s| s.let_off_mm),
    ("drop_mm", |s| s.drop_mm),
    ("aftertouch_mm", |s| s.aftertouch_mm),
    ("check_mm", |s| s.check_mm),
    ("repetition_rise_mm", |s| s.repetition_rise_mm),
    ("repetition_spring_m_per_s", |s| s.repetition_spring_m_per_s),
    ("damper_start_share", |s| s.damper_start_share),
    ("effective_inertia_kg", |s| Some(s.effective_inertia_kg)),
    ("effective_inertia_key_kg", |s| Some(s.effective_inertia_key_kg)),
    ("effective_inertia_whippen_kg", |s| Some(s.effective_inertia_whippen_kg)),
    ("effective_inertia_hammer_kg", |s| Some(s.effective_inertia_hammer_kg)),
    ("let_off_resistance_N", |s| s.let_off_resistance_N),
    ("loop_loss_mJ", |s| Some(s.loop_loss_mJ)),
    ("blocked_front_mm", |s| s.blocked_front_mm),
    ("blocked_back_mm", |s| s.blocked_back_mm),
    ("softest_force_N", |s| s.softest_force_N),
    ("softest_let_off_speed_m_per_s", |s| s.softest_let_off_speed_m_per_s),
    ("softest_fall_speed_m_per_s", |s| s.softest_fall_speed_m_per_s),
    ("double_strike_m_per_s", |s| s.double_strike_m_per_s),
    ("repetition_rate_hz", |s| s.repetition_rate_hz),
    ("repetition_rate_half_hz", |s| s.repetition_rate_half_hz),
];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Norms {
    group: Vec<Group>,
}

/// Lines of the sheet by group, in the order in which they are printed, from `norms.toml`.
pub static GROUPS: LazyLock<Vec<Group>> = LazyLock::new(|| {
    let text = include_str!("norms.toml");
    let mut groups = from_toml::<Norms>(text).expect("the built-in lines read").group;
    for line in groups.iter_mut().flat_map(|group| &mut group.lines) {
        line.value = VALUES.iter().find(|(key, _)| *key == line.key).map_or(no_value(), |(_, value)| *value);
    }
    groups
});

/// Iterates over all lines, those on no page included.
pub fn lines() -> impl Iterator<Item = &'static Line> {
    GROUPS.iter().flat_map(|group| &group.lines)
}

/// Iterates over the lines that pages show.
pub fn page_lines() -> impl Iterator<Item = &'static Line> {
    GROUPS.iter().flat_map(Group::page_lines)
}

impl Group {
    /// Iterates over the lines of the group that pages show.
    pub fn page_lines(&self) -> impl Iterator<Item = &Line> {
        self.lines.iter().filter(|line| !line.on_request)
    }
}

impl Line {
    /// Formats a value with its decimals and its unit; a dash for `None`.
    #[must_use]
    pub fn text(&self, value: Option<f64>) -> String {
        match value {
            Some(value) => format!("{} {}", plain(value, self.decimals), self.unit).trim_end().to_owned(),
            None => "-".to_owned(),
        }
    }

    /// Returns the usual range of the line, if it has one.
    #[must_use]
    pub fn norm(&self) -> Option<&'static UsualRange> {
        usual(self.key)
    }

    /// Usual range at a key, from low to high; either end may be open.
    #[must_use]
    pub fn range(&self, key: usize) -> [Option<f64>; 2] {
        self.norm().map_or([None; 2], |norm| norm.at(key))
    }

    /// Formats the usual range at a key, e.g. `45.0-55.0`; empty without one.
    #[must_use]
    pub fn usual(&self, key: usize) -> String {
        let number = |x: f64| format!("{x:.*}", self.decimals);
        match self.range(key) {
            [Some(low), Some(high)] => format!("{}-{}", number(low), number(high)),
            [Some(low), None] => format!("from {}", number(low)),
            [None, Some(high)] => format!("to {}", number(high)),
            [None, None] => String::new(),
        }
    }

    /// Whether a sheet's value is outside its norm. So is a missing value: the event should have happened.
    #[must_use]
    pub fn is_out(&self, sheet: &Sheet) -> bool {
        self.is_out_at((self.value)(sheet), sheet.norms_for_key)
    }

    /// Whether a value is outside the norm at a key. So is a missing one, except for the damper: top keys have none.
    #[must_use]
    pub(crate) fn is_out_at(&self, value: Option<f64>, key: usize) -> bool {
        if self.norm().is_none() {
            return false;
        }
        let [low, high] = self.range(key);
        match value {
            Some(value) => {
                // Compares rounded values: invisible digits raise no flag.
                let scale = 10_f64.powi(self.decimals as i32);
                let read = |x: f64| (x * scale).round() / scale;
                low.is_some_and(|low| read(value) < read(low)) || high.is_some_and(|high| read(value) > read(high))
            }
            None => self.key != DAMPER && low.is_some(),
        }
    }
}

/// Line of the part missing at some keys.
const DAMPER: &str = "damper_start_share";
/// Largest relative difference of the two ratios, and largest difference of a weight found in two ways, g.
const RATIOS_AGREE: f64 = 0.02;
const WAYS_AGREE_G: f64 = 0.5;

/// How far R by the equation of balance, without the friction that the balance weight contains, is from the lever
/// ratio, as a share; and the difference with that friction in words.
fn ratios_apart(sheet: &Sheet) -> Option<(f64, String)> {
    let levers = sheet.strike_weight_ratio_kinematics;
    let ratio = sheet.strike_weight_ratio_weights?;
    let mut apart = (ratio / levers - 1.0).abs();
    let mut words = format!("R and the lever ratio where D and U are decided differ by {:.1} %", 100.0 * apart);
    if let Some(friction_g) = sheet.friction_in_balance_g {
        apart = ((ratio - friction_g / sheet.strike_weight_g) / levers - 1.0).abs();
        words += &format!("; without the {friction_g:.1} g of friction that BW contains, by {:.1} %", 100.0 * apart);
    }
    if let Some(half_way) = sheet.strike_weight_ratio_weights_half_way {
        let there = half_way / sheet.strike_weight_ratio_kinematics_half_way - 1.0;
        words += &format!("; half-way, where friction cancels, by {:.1} %", 100.0 * there.abs());
    }
    Some((apart, words))
}

/// The sentence with which a page checks R by the levers; `None` without R.
#[must_use]
pub fn ratios_compared(sheet: &Sheet) -> Option<String> {
    let (_, words) = ratios_apart(sheet)?;
    Some(format!("{words} (up to {:.0} % they agree).", 100.0 * RATIOS_AGREE))
}

/// Returns values outside the norm, and values that disagree with each other.
pub(super) fn flags(sheet: &Sheet) -> Vec<Flag> {
    let mut flags = Vec::new();
    for line in lines().filter(|line| line.is_out(sheet)) {
        let label = line.label.trim_start();
        let value = (line.value)(sheet);
        let usual = format!("{} {}", line.usual(sheet.norms_for_key), line.unit);
        // The key is named if the range depends on it.
        let by_key = line.norm().is_some_and(UsualRange::depends_on_the_key);
        let whose = if by_key { format!(" at {}", note_name(sheet.norms_for_key)) } else { String::new() };
        let message = match value {
            Some(_) => format!("{label} {}; usual range {}{whose}", line.text(value), usual.trim_end()),
            None => format!("{label}: could not be measured; usual range {}{whose}", usual.trim_end()),
        };
        flags.push(Flag { key: line.key, message });
    }
    if let Some((apart, message)) = ratios_apart(sheet)
        && apart > RATIOS_AGREE
    {
        flags.push(Flag { key: "strike_weight_ratio_weights", message });
    }
    for (key, what, tried, read) in [
        ("down_weight_g", "down-weight", sheet.down_weight_g, sheet.by_slow_loop.down_weight_g),
        ("up_weight_g", "up-weight", sheet.up_weight_g, sheet.by_slow_loop.up_weight_g),
    ] {
        if let (Some(tried), Some(read)) = (tried, read)
            && (tried - read).abs() > WAYS_AGREE_G
        {
            let message =
                format!("{what} measured with weights ({tried:.1} g) and from the slow loop ({read:.1} g) disagree");
            flags.push(Flag { key, message });
        }
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::range::HARDLY_HEARD_M_PER_S;

    /// A page has one R; other ratios of the sheet are the levers', which no range of R judges.
    #[test]
    fn a_page_has_one_ratio() {
        let ratios: Vec<&Line> = page_lines().filter(|line| line.key.starts_with("strike_weight_ratio")).collect();
        let [r, levers @ ..] = &ratios[..] else { panic!("no R") };
        assert!(r.label.contains(" R ") && r.norm().is_some(), "{r:?}");
        assert_eq!(levers.len(), 3);
        for lever in levers {
            assert!(lever.label.starts_with("lever ratio ") && lever.norm().is_none(), "{lever:?}");
        }
        let asked = lines().filter(|line| line.on_request).inspect(|line| assert!(line.norm().is_none(), "{line:?}"));
        assert_eq!(asked.count() + page_lines().count(), lines().count());
    }

    /// Every line of the file has a value in the sheet, and every value a line.
    #[test]
    fn lines_and_values_belong_together() {
        let (keys, values) = (lines().map(|line| line.key), VALUES.iter().map(|(key, _)| *key));
        assert_eq!(keys.collect::<Vec<_>>(), values.collect::<Vec<_>>());
        let twice = lines().find(|line| line.key == "double_strike_m_per_s").unwrap();
        assert_eq!(twice.range(40), [None, Some(HARDLY_HEARD_M_PER_S)]);
    }

    /// At the sources' keys their numbers, linear between them, constant beyond; those of middle C are unchanged.
    #[test]
    fn norms_follow_the_register() {
        let line = |key: &str| lines().find(|line| line.key == key).unwrap();
        assert_eq!(line("strike_weight_g").usual(40), "8.5-10.5");
        assert_eq!(line("strike_weight_g").usual(88), "4.6-5.8");
        assert_eq!(line("strike_weight_g").usual(1), "10.3-12.4");
        // Half-way from 9.7 to 8.5 and from 11.8 to 10.5.
        assert_eq!(line("strike_weight_g").range(28), [Some(9.1), Some(11.15)]);
        assert_eq!(line("friction_weight_g").usual(40), "9.0-12.5");
        // 16 g in the bass and 10 g in the treble are normal.
        for (key, grams) in [(1, 16.0), (88, 10.0)] {
            let [low, high] = line("friction_weight_g").range(key);
            assert!(low.unwrap() < grams && grams < high.unwrap(), "{key}");
        }
        assert_eq!(line("effective_inertia_kg").usual(40), "0.200-0.350");
        assert_eq!(line("dip_mm").usual(1), line("dip_mm").usual(88));
        // D = BW + F and U = BW - F at the ends of both.
        for key in [1, 20, 40, 64, 88] {
            let of = |name: &str| line(name).range(key).map(Option::unwrap);
            let ([b_low, b_high], [f_low, f_high]) = (of("balance_weight_g"), of("friction_weight_g"));
            let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{key}: {a} {b}");
            let ([d_low, d_high], [u_low, u_high]) = (of("down_weight_g"), of("up_weight_g"));
            near(d_low, b_low + f_low);
            near(d_high, b_high + f_high);
            near(u_low, b_low - f_high);
            near(u_high, b_high - f_low);
        }
        assert_eq!(line("lost_motion_mm").usual(40), "");
    }
}
