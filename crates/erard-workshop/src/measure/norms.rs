//! The lines of the sheet: what they are called, their unit, how many digits a technician reads, and what is usual.

use serde::Serialize;

use super::sheet::Sheet;

/// What is usual, and who says so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Norm {
    /// Lower end; `None` is open.
    pub low: Option<f64>,
    /// Upper end; `None` is open.
    pub high: Option<f64>,
    /// Where it was read, and what was made of it.
    pub source: &'static str,
}

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
    Some(Norm { low: Some(low), high: Some(high), source })
}

const fn at_least(low: f64, source: &'static str) -> Option<Norm> {
    Some(Norm { low: Some(low), high: None, source })
}

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
                between(8.0, 14.0, "Stanwood 1995-96: 9-12.5 g in mid keyboard, 16 g bass to 10 g treble"),
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
            line(
                "strike_weight_g",
                "strike weight SW",
                "g",
                1,
                |s| Some(s.strike_weight_g),
                between(
                    8.5,
                    10.5,
                    "Stanwood 1997: 6.8-8.6 g head alone near note 40, with 1.7-1.9 g of shank (estimate)",
                ),
            ),
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
            line("repetition_spring_m_s", "  its speed (spring)", "m/s", 2, |s| s.repetition_spring_m_s, None),
            line("damper_start_share", "damper starts, of the dip", "", 2, |s| s.damper_start_share, None),
        ],
    },
    Group {
        heading: "Inertia at the key front (half-way, pedal down)",
        lines: &[
            line(
                "effective_inertia_kg",
                "effective inertia",
                "kg",
                3,
                |s| Some(s.effective_inertia_kg),
                between(0.2, 0.35, "0.286 kg Hartman, 0.215-0.226 kg pianobytes; 0.2-0.35 kg is let pass here"),
            ),
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

    /// What is usual, e.g. `45.0-55.0`; empty where nothing is.
    #[must_use]
    pub fn usual(&self) -> String {
        let number = |x: f64| format!("{x:.*}", self.decimals);
        match self.norm {
            Some(Norm { low: Some(low), high: Some(high), .. }) => format!("{}-{}", number(low), number(high)),
            Some(Norm { low: Some(low), .. }) => format!("from {}", number(low)),
            Some(Norm { high: Some(high), .. }) => format!("to {}", number(high)),
            _ => String::new(),
        }
    }

    /// Whether a sheet's value is out of the norm. A value that is missing is: what did not happen should have.
    #[must_use]
    pub fn is_out(&self, sheet: &Sheet) -> bool {
        let Some(norm) = self.norm else { return false };
        match (self.value)(sheet) {
            Some(value) => {
                // As it is read: digits that no technician sees raise no flag.
                let scale = 10_f64.powi(self.decimals as i32);
                let read = (value * scale).round() / scale;
                norm.low.is_some_and(|low| read < low) || norm.high.is_some_and(|high| read > high)
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
        let message = match value {
            Some(_) => format!("{label} {}: usual is {} {}", line.text(value), line.usual(), line.unit),
            None => format!("{label}: not to be had; usual is {} {}", line.usual(), line.unit),
        };
        flags.push(Flag { key: line.key, message: message.trim_end().to_owned() });
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
