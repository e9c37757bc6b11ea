//! The lines of the sheet: what they are called, their unit, how many digits a technician reads. Their usual ranges are in [`super::usual`].

use serde::Serialize;

use super::sheet::Sheet;
use super::usual::{UsualRange, usual};
use erard::keyboard::note_name;

/// The key whose norms hold where nobody says which it is: middle C.
pub const MIDDLE_C: usize = 40;

/// One line of the sheet.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    /// The key in `measure.json`.
    pub key: &'static str,
    /// For people.
    pub label: &'static str,
    /// Its unit; empty for a ratio.
    pub unit: &'static str,
    /// Decimals that mean something.
    pub decimals: usize,
    /// Its value.
    pub value: fn(&Sheet) -> Option<f64>,
}

/// What is out of the norm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Flag {
    /// The line's key.
    pub key: &'static str,
    /// What is wrong, a line for people.
    pub message: String,
}

/// Lines that belong together.
#[derive(Debug, Clone, Copy)]
pub struct Group {
    /// Its heading.
    pub heading: &'static str,
    /// Its lines.
    pub lines: &'static [Line],
}

const fn line(
    key: &'static str,
    label: &'static str,
    unit: &'static str,
    decimals: usize,
    value: fn(&Sheet) -> Option<f64>,
) -> Line {
    Line { key, label, unit, decimals, value }
}

/// The sheet's lines, in the order in which they are printed.
pub const GROUPS: [Group; 6] = [
    Group {
        heading: "Weights on the key (pedal down, weight on the key front)",
        lines: &[
            line("down_weight_g", "down-weight D", "g", 1, |s| s.down_weight_g),
            line("up_weight_g", "up-weight U", "g", 1, |s| s.up_weight_g),
            line("balance_weight_g", "balance weight (D+U)/2", "g", 1, |s| s.balance_weight_g),
            line("friction_weight_g", "friction weight (D-U)/2", "g", 1, |s| s.friction_weight_g),
            line("dampers_down.down_weight_g", "dampers down: down-weight", "g", 1, |s| s.dampers_down?.down_weight_g),
            line("dampers_down.up_weight_g", "  up-weight", "g", 1, |s| s.dampers_down?.up_weight_g),
            line("dampers_down.friction_weight_g", "  friction weight", "g", 1, |s| s.dampers_down?.friction_weight_g),
            line("by_slow_loop.down_weight_g", "from a slow loop: down-weight", "g", 1, |s| {
                s.by_slow_loop.down_weight_g
            }),
            line("by_slow_loop.up_weight_g", "  up-weight", "g", 1, |s| s.by_slow_loop.up_weight_g),
        ],
    },
    Group {
        heading: "Parts on the scale, and the equation of balance BW + FW = KR WW + R SW",
        lines: &[
            line("front_weight_g", "front weight FW", "g", 1, |s| Some(s.front_weight_g)),
            line("strike_weight_g", "strike weight SW", "g", 1, |s| Some(s.strike_weight_g)),
            line("whippen_weight_g", "whippen weight WW", "g", 1, |s| Some(s.whippen_weight_g)),
            line("key_ratio", "key ratio KR", "", 3, |s| Some(s.key_ratio)),
            line("strike_weight_ratio_weights", "strike-weight ratio R by weights", "", 2, |s| {
                s.strike_weight_ratio_weights
            }),
            line("strike_weight_ratio_kinematics", "  R by the geometry, where weighed", "", 2, |s| {
                Some(s.strike_weight_ratio_kinematics)
            }),
            line("strike_weight_ratio_weights_half_way", "half-way: R by the loop's forces", "", 2, |s| {
                s.strike_weight_ratio_weights_half_way
            }),
            line("strike_weight_ratio_kinematics_half_way", "  R by the geometry", "", 2, |s| {
                Some(s.strike_weight_ratio_kinematics_half_way)
            }),
            line("strike_weight_ratio_kinematics_at_rest", "  R by the geometry at rest", "", 2, |s| {
                Some(s.strike_weight_ratio_kinematics_at_rest)
            }),
            line("strike_weight_ratio_kinematics_at_let_off", "  and where let-off begins", "", 2, |s| {
                Some(s.strike_weight_ratio_kinematics_at_let_off)
            }),
        ],
    },
    Group {
        heading: "Regulation",
        lines: &[
            line("dip_mm", "dip", "mm", 1, |s| s.dip_mm),
            line("blow_mm", "blow", "mm", 1, |s| s.blow_mm),
            line("lost_motion_mm", "lost motion", "mm", 1, |s| s.lost_motion_mm),
            line("let_off_begins_mm", "key where let-off begins", "mm", 1, |s| s.let_off_begins_mm),
            line("let_off_mm", "let-off", "mm", 1, |s| s.let_off_mm),
            line("drop_mm", "drop", "mm", 1, |s| s.drop_mm),
            line("aftertouch_mm", "aftertouch", "mm", 1, |s| s.aftertouch_mm),
            line("check_mm", "check distance", "mm", 1, |s| s.check_mm),
            line("repetition_rise_mm", "rise from the check", "mm", 1, |s| s.repetition_rise_mm),
            line("repetition_spring_m_s", "  its speed (spring)", "m/s", 2, |s| s.repetition_spring_m_s),
            line("damper_start_share", "damper starts, of the dip", "", 2, |s| s.damper_start_share),
        ],
    },
    Group {
        heading: "Inertia at the key front (half-way, pedal down)",
        lines: &[
            line("effective_inertia_kg", "effective inertia", "kg", 3, |s| Some(s.effective_inertia_kg)),
            line("effective_inertia_key_kg", "  key", "kg", 3, |s| Some(s.effective_inertia_key_kg)),
            line("effective_inertia_whippen_kg", "  whippen", "kg", 3, |s| Some(s.effective_inertia_whippen_kg)),
            line("effective_inertia_hammer_kg", "  hammer", "kg", 3, |s| Some(s.effective_inertia_hammer_kg)),
        ],
    },
    Group {
        heading: "Slow loop to the bottom and back",
        lines: &[
            line("let_off_resistance_N", "let-off resistance", "N", 2, |s| s.let_off_resistance_N),
            line("loop_loss_mJ", "work that stays in the action", "mJ", 2, |s| Some(s.loop_loss_mJ)),
        ],
    },
    Group {
        heading: "Speech and repetition",
        lines: &[
            line("softest_force_N", "softest force that sounds", "N", 2, |s| s.softest_force_N),
            line("softest_let_off_speed_m_s", "  hammer at let-off", "m/s", 2, |s| s.softest_let_off_speed_m_s),
            line("softest_fall_speed_m_s", "  sqrt(2 a d) of its flight", "m/s", 2, |s| s.softest_fall_speed_m_s),
            line("double_strike_m_s", "  second blow of a soft note", "m/s", 2, |s| s.double_strike_m_s),
            line("repetition_rate_hz", "repetition, fully released", "Hz", 1, |s| s.repetition_rate_hz),
            line("repetition_rate_half_hz", "  from half-way", "Hz", 1, |s| s.repetition_rate_half_hz),
        ],
    },
];

/// All lines.
pub fn lines() -> impl Iterator<Item = &'static Line> {
    GROUPS.iter().flat_map(|group| group.lines)
}

impl Line {
    /// A value with its decimals and its unit; a dash where there is none.
    #[must_use]
    pub fn text(&self, value: Option<f64>) -> String {
        match value {
            // Adding zero turns -0 into 0.
            Some(value) => format!("{:.*} {}", self.decimals, value + 0.0, self.unit).trim_end().to_owned(),
            None => "-".to_owned(),
        }
    }

    /// Its usual range, if it has one.
    #[must_use]
    pub fn norm(&self) -> Option<&'static UsualRange> {
        usual(self.key)
    }

    /// What is usual at a key, from low to high; either end may be open.
    #[must_use]
    pub fn range(&self, key: usize) -> [Option<f64>; 2] {
        self.norm().map_or([None; 2], |norm| norm.at(key))
    }

    /// What is usual at a key, e.g. `45.0-55.0`; empty where nothing is.
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

    /// Whether a sheet's value is out of the norm. A value that is missing is: what did not happen should have.
    #[must_use]
    pub fn is_out(&self, sheet: &Sheet) -> bool {
        if self.norm().is_none() {
            return false;
        }
        let [low, high] = self.range(sheet.norms_for_key);
        match (self.value)(sheet) {
            Some(value) => {
                // As it is read: digits that no technician sees raise no flag.
                let scale = 10_f64.powi(self.decimals as i32);
                let read = |x: f64| (x * scale).round() / scale;
                low.is_some_and(|low| read(value) < read(low)) || high.is_some_and(|high| read(value) > read(high))
            }
            None => true,
        }
    }
}

/// The two ratios, and the two ways to a weight, may differ by so much.
const RATIOS_AGREE: f64 = 0.02;
const WAYS_AGREE_G: f64 = 0.5;

/// What is out of the norm, or does not agree with itself.
pub(super) fn flags(sheet: &Sheet) -> Vec<Flag> {
    let mut flags = Vec::new();
    for line in lines().filter(|line| line.is_out(sheet)) {
        let label = line.label.trim_start();
        let value = (line.value)(sheet);
        let usual = format!("{} {}", line.usual(sheet.norms_for_key), line.unit);
        // Where it depends on the key, whose it is.
        let by_key = line.norm().is_some_and(UsualRange::depends_on_the_key);
        let whose = if by_key { format!(" at {}", note_name(sheet.norms_for_key)) } else { String::new() };
        let message = match value {
            Some(_) => format!("{label} {}: usual is {}{whose}", line.text(value), usual.trim_end()),
            None => format!("{label}: not to be had; usual is {}{whose}", usual.trim_end()),
        };
        flags.push(Flag { key: line.key, message });
    }
    if let Some(weights) = sheet.strike_weight_ratio_weights {
        let apart = weights / sheet.strike_weight_ratio_kinematics - 1.0;
        if apart.abs() > RATIOS_AGREE {
            let mut message = format!("R by weights and R by the geometry are {:.1} % apart", 100.0 * apart.abs());
            if let Some(half_way) = sheet.strike_weight_ratio_weights_half_way {
                // Down-weight and up-weight are decided at different places: friction that differs between them stays in BW.
                let there = half_way / sheet.strike_weight_ratio_kinematics_half_way - 1.0;
                message += &format!("; half-way, where friction goes out, {:.1} %", 100.0 * there.abs());
            }
            flags.push(Flag { key: "strike_weight_ratio_weights", message });
        }
    }
    for (key, what, tried, read) in [
        ("down_weight_g", "down-weight", sheet.down_weight_g, sheet.by_slow_loop.down_weight_g),
        ("up_weight_g", "up-weight", sheet.up_weight_g, sheet.by_slow_loop.up_weight_g),
    ] {
        if let (Some(tried), Some(read)) = (tried, read)
            && (tried - read).abs() > WAYS_AGREE_G
        {
            let message = format!("{what} by weights {tried:.1} g and from the slow loop {read:.1} g do not agree");
            flags.push(Flag { key, message });
        }
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At the keys of the sources their numbers, between them a straight line, beyond them the nearest; middle C's are those of before.
    #[test]
    fn norms_follow_the_register() {
        let line = |key: &str| lines().find(|line| line.key == key).unwrap();
        assert_eq!(line("strike_weight_g").usual(40), "8.5-10.5");
        assert_eq!(line("strike_weight_g").usual(88), "4.6-6.4");
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
        assert_eq!(line("down_weight_g").usual(1), line("down_weight_g").usual(88));
        assert_eq!(line("lost_motion_mm").usual(40), "");
    }
}
