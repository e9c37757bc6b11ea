//! The lines of the sheet: what they are called, their unit, how many digits a technician reads, and what is usual.

use serde::Serialize;

use super::range::HARDLY_HEARD_M_S;
use super::sheet::Sheet;
use erard::keyboard::note_name;

/// What is usual, and who says so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Norm {
    /// Lower end.
    pub low: Limit,
    /// Upper end.
    pub high: Limit,
    /// Where it was read, and what was made of it.
    pub source: &'static str,
}

/// One end of what is usual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// There is none.
    Open,
    /// The same for all keys.
    All(f64),
    /// At some keys, ascending, and on straight lines between them; beyond the first and the last as there.
    ByKey(&'static [(usize, f64)]),
}

impl Limit {
    /// At a key, 1 to 88.
    #[must_use]
    pub(crate) fn at(&self, key: usize) -> Option<f64> {
        match *self {
            Limit::Open => None,
            Limit::All(value) => Some(value),
            Limit::ByKey(points) => {
                let after = points.partition_point(|(at, _)| *at <= key);
                let &(left, from) = points.get(after.saturating_sub(1))?;
                Some(match points.get(after) {
                    Some(&(right, to)) if key > left => {
                        from + (to - from) * (key - left) as f64 / (right - left) as f64
                    }
                    _ => from,
                })
            }
        }
    }
}

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
    /// What is usual, if anything is.
    pub norm: Option<Norm>,
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

const STANWOOD: &str = "Stanwood 1995-96, Love, Ballard (Pianotech list)";
const REGULATION: &str = "Brekne 2009 (Yamaha academy), Gillespie et al. 2011, technicians' guides";
const REGULATION_HALF: &str = "1.5 mm in the same guides; half a millimetre either way is this sheet's tolerance";

const fn between(low: f64, high: f64, source: &'static str) -> Option<Norm> {
    Some(Norm { low: Limit::All(low), high: Limit::All(high), source })
}

const fn at_least(low: f64, source: &'static str) -> Option<Norm> {
    Some(Norm { low: Limit::All(low), high: Limit::Open, source })
}

const fn at_most(high: f64, source: &'static str) -> Option<Norm> {
    Some(Norm { low: Limit::Open, high: Limit::All(high), source })
}

/// Strike weights of medium hammers. Lower ends: Stanwood's guideline at notes 1 and 88, 10.3 and 4.6 g (Pianotech list, 12 July 1995), and his
/// heads without shank at notes 16, 40 and 64, 8.0, 6.8 and 5.1 g (1997), with 1.7 g of shank. Upper ends: those heads' upper ends, 9.9, 8.6 and
/// 6.7 g, with 1.9 g of shank; at notes 1 and 88 as far above the lower end as at notes 16 and 64.
const STRIKE_WEIGHT: Norm = Norm {
    low: Limit::ByKey(&[(1, 10.3), (16, 9.7), (40, 8.5), (64, 6.8), (88, 4.6)]),
    high: Limit::ByKey(&[(1, 12.4), (16, 11.8), (40, 10.5), (64, 8.6), (88, 6.4)]),
    source: "Stanwood 1995 (notes 1, 88) and 1997 (heads alone, notes 16, 40, 64, with 1.7-1.9 g of shank)",
};

/// Friction weights: published are 16 g in the bass, 9 to 12.5 g in the middle and 10 g in the treble (Stanwood 1995, Love, Ballard). 14 g pass
/// in the middle, 3.25 g above the middle of 9 to 12.5; as much is let pass above 16 and 10 g. Little friction is let pass everywhere, to 8 g in
/// bass and middle, as far below the middle, to 7.2 g in the treble.
const FRICTION_WEIGHT: Norm = Norm {
    low: Limit::ByKey(&[(40, 8.0), (88, 7.2)]),
    high: Limit::ByKey(&[(1, 19.2), (40, 14.0), (88, 13.2)]),
    source: "Stanwood 1995, Love, Ballard: 16 g bass, 9-12.5 g in mid keyboard, 10 g treble; 3.2 g more are let pass",
};

/// Effective inertia: the published numbers (0.286 kg Hartman, 0.215 to 0.226 kg pianobytes) name no key and are taken for middle C, where 0.2 to
/// 0.35 kg pass. Four fifths of it are the hammer's here, which go with the usual strike weight: x (0.2 + 0.8 SW / 9.5 g) at the middle of what
/// is usual, 11.35, 10.75, 9.5, 7.7 and 5.5 g. An estimate.
const INERTIA: Norm = Norm {
    low: Limit::ByKey(&[(1, 0.231), (16, 0.221), (40, 0.2), (64, 0.17), (88, 0.133)]),
    high: Limit::ByKey(&[(1, 0.405), (16, 0.387), (40, 0.35), (64, 0.297), (88, 0.232)]),
    source: "0.286 kg Hartman, 0.215-0.226 kg pianobytes, taken for middle C; 0.2-0.35 kg are let pass there, elsewhere with the strike weight",
};

const fn line(
    key: &'static str,
    label: &'static str,
    unit: &'static str,
    decimals: usize,
    value: fn(&Sheet) -> Option<f64>,
    norm: Option<Norm>,
) -> Line {
    Line { key, label, unit, decimals, value, norm }
}

/// The sheet's lines, in the order in which they are printed.
pub const GROUPS: [Group; 6] = [
    Group {
        heading: "Weights on the key (pedal down, weight on the key front)",
        lines: &[
            line("down_weight_g", "down-weight D", "g", 1, |s| s.down_weight_g, between(45.0, 55.0, STANWOOD)),
            line(
                "up_weight_g",
                "up-weight U",
                "g",
                1,
                |s| s.up_weight_g,
                between(20.0, 30.0, "Stanwood 1995-96, Love, Ballard: 20-25 g; up to 30 g is let pass here"),
            ),
            line(
                "balance_weight_g",
                "balance weight (D+U)/2",
                "g",
                1,
                |s| s.balance_weight_g,
                between(34.0, 40.0, STANWOOD),
            ),
            line(
                "friction_weight_g",
                "friction weight (D-U)/2",
                "g",
                1,
                |s| s.friction_weight_g,
                Some(FRICTION_WEIGHT),
            ),
            line(
                "dampers_down.down_weight_g",
                "dampers down: down-weight",
                "g",
                1,
                |s| s.dampers_down?.down_weight_g,
                None,
            ),
            line("dampers_down.up_weight_g", "  up-weight", "g", 1, |s| s.dampers_down?.up_weight_g, None),
            line(
                "dampers_down.friction_weight_g",
                "  friction weight",
                "g",
                1,
                |s| s.dampers_down?.friction_weight_g,
                None,
            ),
            line(
                "by_slow_loop.down_weight_g",
                "from a slow loop: down-weight",
                "g",
                1,
                |s| s.by_slow_loop.down_weight_g,
                None,
            ),
            line("by_slow_loop.up_weight_g", "  up-weight", "g", 1, |s| s.by_slow_loop.up_weight_g, None),
        ],
    },
    Group {
        heading: "Parts on the scale, and the equation of balance BW + FW = KR WW + R SW",
        lines: &[
            line("front_weight_g", "front weight FW", "g", 1, |s| Some(s.front_weight_g), None),
            line("strike_weight_g", "strike weight SW", "g", 1, |s| Some(s.strike_weight_g), Some(STRIKE_WEIGHT)),
            line(
                "whippen_weight_g",
                "whippen weight WW",
                "g",
                1,
                |s| Some(s.whippen_weight_g),
                between(16.0, 20.0, "Stanwood 1996: 18 g at the heel; two grams either way are this sheet's tolerance"),
            ),
            line(
                "key_ratio",
                "key ratio KR",
                "",
                3,
                |s| Some(s.key_ratio),
                between(0.50, 0.56, "Stanwood 1996: about 0.5; Overs 2001: 0.547; Delacour 2001: 0.536"),
            ),
            line(
                "strike_weight_ratio_weights",
                "strike-weight ratio R by weights",
                "",
                2,
                |s| s.strike_weight_ratio_weights,
                between(5.0, 6.06, STANWOOD),
            ),
            line(
                "strike_weight_ratio_kinematics",
                "  R by the geometry, where weighed",
                "",
                2,
                |s| Some(s.strike_weight_ratio_kinematics),
                between(5.0, 6.06, STANWOOD),
            ),
            line(
                "strike_weight_ratio_weights_half_way",
                "half-way: R by the loop's forces",
                "",
                2,
                |s| s.strike_weight_ratio_weights_half_way,
                None,
            ),
            line(
                "strike_weight_ratio_kinematics_half_way",
                "  R by the geometry",
                "",
                2,
                |s| Some(s.strike_weight_ratio_kinematics_half_way),
                None,
            ),
            line(
                "strike_weight_ratio_kinematics_at_rest",
                "  R by the geometry at rest",
                "",
                2,
                |s| Some(s.strike_weight_ratio_kinematics_at_rest),
                None,
            ),
            line(
                "strike_weight_ratio_kinematics_at_let_off",
                "  and where let-off begins",
                "",
                2,
                |s| Some(s.strike_weight_ratio_kinematics_at_let_off),
                None,
            ),
        ],
    },
    Group {
        heading: "Regulation",
        lines: &[
            line("dip_mm", "dip", "mm", 1, |s| s.dip_mm, between(9.5, 11.0, REGULATION)),
            line("blow_mm", "blow", "mm", 1, |s| s.blow_mm, between(44.0, 49.0, REGULATION)),
            line("lost_motion_mm", "lost motion", "mm", 1, |s| s.lost_motion_mm, None),
            line("let_off_begins_mm", "key where let-off begins", "mm", 1, |s| s.let_off_begins_mm, None),
            line("let_off_mm", "let-off", "mm", 1, |s| s.let_off_mm, between(1.0, 2.0, REGULATION_HALF)),
            line("drop_mm", "drop", "mm", 1, |s| s.drop_mm, between(1.0, 2.0, REGULATION_HALF)),
            line(
                "aftertouch_mm",
                "aftertouch",
                "mm",
                1,
                |s| s.aftertouch_mm,
                between(
                    0.5,
                    1.5,
                    "about 1 mm in the same guides; half a millimetre either way is this sheet's tolerance",
                ),
            ),
            line("check_mm", "check distance", "mm", 1, |s| s.check_mm, between(12.0, 15.0, REGULATION)),
            line("repetition_rise_mm", "rise from the check", "mm", 1, |s| s.repetition_rise_mm, None),
            line(
                "repetition_spring_m_s",
                "  its speed (spring)",
                "m/s",
                2,
                |s| s.repetition_spring_m_s,
                between(
                    0.2,
                    0.45,
                    "no published number: `regulate` aims at 0.25 m/s, a brisk rise without a kick; a fifth less passes, and more where no soft note strikes twice",
                ),
            ),
            line("damper_start_share", "damper starts, of the dip", "", 2, |s| s.damper_start_share, None),
        ],
    },
    Group {
        heading: "Inertia at the key front (half-way, pedal down)",
        lines: &[
            line("effective_inertia_kg", "effective inertia", "kg", 3, |s| Some(s.effective_inertia_kg), Some(INERTIA)),
            line("effective_inertia_key_kg", "  key", "kg", 3, |s| Some(s.effective_inertia_key_kg), None),
            line("effective_inertia_whippen_kg", "  whippen", "kg", 3, |s| Some(s.effective_inertia_whippen_kg), None),
            line("effective_inertia_hammer_kg", "  hammer", "kg", 3, |s| Some(s.effective_inertia_hammer_kg), None),
        ],
    },
    Group {
        heading: "Slow loop to the bottom and back",
        lines: &[
            line("let_off_resistance_N", "let-off resistance", "N", 2, |s| s.let_off_resistance_N, None),
            line("loop_loss_mJ", "work that stays in the action", "mJ", 2, |s| Some(s.loop_loss_mJ), None),
        ],
    },
    Group {
        heading: "Speech and repetition",
        lines: &[
            line("softest_force_N", "softest force that sounds", "N", 2, |s| s.softest_force_N, None),
            line("softest_let_off_speed_m_s", "  hammer at let-off", "m/s", 2, |s| s.softest_let_off_speed_m_s, None),
            line("softest_fall_speed_m_s", "  sqrt(2 a d) of its flight", "m/s", 2, |s| s.softest_fall_speed_m_s, None),
            line(
                "double_strike_m_s",
                "  second blow of a soft note",
                "m/s",
                2,
                |s| s.double_strike_m_s,
                at_most(
                    HARDLY_HEARD_M_S,
                    "a well-regulated action has none; no published number: one of 0.15 m/s is hardly heard",
                ),
            ),
            line("repetition_rate_hz", "repetition, fully released", "Hz", 1, |s| s.repetition_rate_hz, None),
            line(
                "repetition_rate_half_hz",
                "  from half-way",
                "Hz",
                1,
                |s| s.repetition_rate_half_hz,
                at_least(12.0, "12-14 per second on a grand: craftpiano, player-piano digest"),
            ),
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

    /// What is usual at a key, from low to high; either end may be open.
    #[must_use]
    pub fn range(&self, key: usize) -> [Option<f64>; 2] {
        self.norm.map_or([None; 2], |norm| [norm.low.at(key), norm.high.at(key)])
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
        if self.norm.is_none() {
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
        let by_key = line.norm.is_some_and(|norm| matches!(norm.high, Limit::ByKey(_)));
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
        assert_eq!(line("friction_weight_g").usual(40), "8.0-14.0");
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
