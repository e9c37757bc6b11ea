//! The numbers of all cases: printed side by side, and as `summary.json`.

use std::fmt;

use erard_workshop::kinematics::{Agreement, Derived, Design, Spot};
use moreau_linkage::three_lever::LeverArms;
use serde::Serialize;

use super::Shown;

/// The numbers. `None` (JSON `null`) is what cannot be reached or is not known.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Summary {
    /// Name of linkage or instrument.
    pub name: String,
    /// `linkage` or `instrument`.
    pub kind: &'static str,
    /// Whether the hammer's rest was kept by the capstan's height after a move.
    pub regulated: bool,
    /// What happens at let-off.
    pub let_off_is: Option<String>,
    /// The cases, the design as it is first.
    pub cases: Vec<CaseNumbers>,
    /// The nearest lengths L1 to L10 of an instrument, mm.
    pub lengths_mm: Option<[f64; 10]>,
    /// Zones of the instrument that are the two contacts: capstan and knuckle.
    pub contacts: Option<[String; 2]>,
    /// How an instrument's geometry agrees with its dynamics.
    pub dynamics: Option<Dynamics>,
    /// What to know about an instrument's rest.
    pub notes: Vec<String>,
}

/// One case.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct CaseNumbers {
    /// As on the command line and in the table.
    pub case: String,
    /// For people.
    #[serde(skip)]
    label: String,
    /// Leverage at three key positions.
    pub leverage: Leverages,
    /// Largest sliding away from rest, between rest and let-off, mm.
    pub capstan_sliding_mm: Option<f64>,
    /// The whole way to and fro, mm.
    pub capstan_way_mm: Option<f64>,
    /// Largest sliding away from rest, mm.
    pub knuckle_sliding_mm: Option<f64>,
    /// The whole way to and fro, mm.
    pub knuckle_way_mm: Option<f64>,
    /// The six classical lever arms at rest, mm.
    pub lever_arms_mm: Arms,
    /// key back / key front x whippen jack / heel x hammer head / knuckle.
    pub lever_arm_product: f64,
    /// Largest residual of the closure equations over the largest length, of all poses of the table.
    pub largest_residual: f64,
    /// Where the poses stop short, mm of key travel.
    pub stopped_at_key_mm: Option<f64>,
}

/// Leverage at rest, half-way to let-off, and at let-off.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Leverages {
    /// At rest.
    pub start: At,
    /// Half-way to let-off.
    pub middle: Option<At>,
    /// At let-off.
    pub let_off: Option<At>,
}

/// Leverage at a key position.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct At {
    /// mm.
    pub key_mm: f64,
    /// Hammer-head speed over key-front speed.
    pub leverage: f64,
}

impl From<Spot> for At {
    fn from(spot: Spot) -> Self {
        At { key_mm: spot.key_m * 1e3, leverage: spot.leverage }
    }
}

/// The six classical lever arms, mm.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Arms {
    /// Key pivot to finger.
    pub key_front: f64,
    /// Key pivot to capstan contact.
    pub key_back: f64,
    /// Whippen pivot to capstan contact.
    pub whippen_heel: f64,
    /// Whippen pivot to knuckle contact.
    pub whippen_jack: f64,
    /// Hammer pivot to knuckle contact.
    pub hammer_knuckle: f64,
    /// Hammer pivot to strike point.
    pub hammer_head: f64,
}

impl From<LeverArms> for Arms {
    fn from(arms: LeverArms) -> Self {
        Arms {
            key_front: arms.key_front * 1e3,
            key_back: arms.key_back * 1e3,
            whippen_heel: arms.whippen_heel * 1e3,
            whippen_jack: arms.whippen_jack * 1e3,
            hammer_knuckle: arms.hammer_knuckle * 1e3,
            hammer_head: arms.hammer_head * 1e3,
        }
    }
}

/// Agreement with a slow press of the dynamic model.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Dynamics {
    /// Largest deviation of leverage, a part of it.
    pub largest_deviation: f64,
    /// From this key position, where play and felts are taken up, mm,
    pub from_key_mm: f64,
    /// to this one, shortly before let-off, mm.
    pub to_key_mm: f64,
}

impl From<&Agreement> for Dynamics {
    fn from(agreement: &Agreement) -> Self {
        let mm = |key: Option<&f64>| key.copied().unwrap_or(0.0) * 1e3;
        Dynamics {
            largest_deviation: agreement.worst,
            from_key_mm: mm(agreement.key_m.first()),
            to_key_mm: mm(agreement.key_m.last()),
        }
    }
}

impl CaseNumbers {
    fn new(shown: &Shown) -> Self {
        let digest = &shown.digest;
        // Slidings belong to the stroke to let-off: without one there are none.
        let mm = |metres: f64| digest.let_off.map(|_| metres * 1e3);
        CaseNumbers {
            case: shown.name.clone(),
            label: shown.label.clone(),
            leverage: Leverages {
                start: digest.start.into(),
                middle: digest.middle.map(At::from),
                let_off: digest.let_off.map(At::from),
            },
            capstan_sliding_mm: mm(digest.capstan_sliding_m),
            capstan_way_mm: mm(digest.capstan_way_m),
            knuckle_sliding_mm: mm(digest.knuckle_sliding_m),
            knuckle_way_mm: mm(digest.knuckle_way_m),
            lever_arms_mm: digest.arms.into(),
            lever_arm_product: digest.arms.product(),
            largest_residual: shown.stroke.poses.iter().map(|pose| pose.residual).fold(0.0, f64::max),
            stopped_at_key_mm: shown.stroke.stop.as_ref().map(|stop| stop.key * 1e3),
        }
    }
}

impl Summary {
    /// The numbers of a design and its cases; `derived` and `dynamics` for an instrument.
    pub(crate) fn new(
        design: &Design,
        regulated: bool,
        cases: &[Shown],
        derived: Option<&Derived>,
        dynamics: Option<&Agreement>,
    ) -> Self {
        Summary {
            name: design.name.clone(),
            kind: if derived.is_some() { "instrument" } else { "linkage" },
            regulated,
            let_off_is: design.let_off.as_ref().map(|let_off| let_off.what.clone()),
            cases: cases.iter().map(CaseNumbers::new).collect(),
            lengths_mm: derived.map(|derived| derived.lengths.lengths.to_array().map(|length| length * 1e3)),
            contacts: derived.map(|derived| [derived.capstan_zone.clone(), derived.knuckle_zone.clone()]),
            dynamics: dynamics.map(Dynamics::from),
            notes: derived.map_or(Vec::new(), |derived| derived.notes.clone()),
        }
    }

    /// The rows: what, and one value per case.
    fn rows(&self) -> Vec<(&'static str, Vec<String>)> {
        let leverage = |at: Option<At>| at.map_or("-".to_owned(), |at| format!("{:.3}", at.leverage));
        let mm = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2} mm"));
        let each = |value: &dyn Fn(&CaseNumbers) -> String| self.cases.iter().map(value).collect::<Vec<String>>();
        let arm = |arm: fn(&Arms) -> f64| each(&|c| format!("{:.1} mm", arm(&c.lever_arms_mm)));
        vec![
            ("leverage at rest", each(&|c| leverage(Some(c.leverage.start)))),
            ("  half-way to let-off", each(&|c| leverage(c.leverage.middle))),
            ("  at let-off", each(&|c| leverage(c.leverage.let_off))),
            ("key at let-off", each(&|c| mm(c.leverage.let_off.map(|at| at.key_mm)))),
            ("capstan sliding, at most", each(&|c| mm(c.capstan_sliding_mm))),
            ("  whole way", each(&|c| mm(c.capstan_way_mm))),
            ("knuckle sliding, at most", each(&|c| mm(c.knuckle_sliding_mm))),
            ("  whole way", each(&|c| mm(c.knuckle_way_mm))),
            ("lever arms: key, front", arm(|arms| arms.key_front)),
            ("  key, capstan", arm(|arms| arms.key_back)),
            ("  whippen, heel", arm(|arms| arms.whippen_heel)),
            ("  whippen, jack", arm(|arms| arms.whippen_jack)),
            ("  hammer, knuckle", arm(|arms| arms.hammer_knuckle)),
            ("  hammer, head", arm(|arms| arms.hammer_head)),
            ("  product of the three ratios", each(&|c| format!("{:.3}", c.lever_arm_product))),
            ("largest residual", each(&|c| format!("{:.1e}", c.largest_residual))),
        ]
    }
}

/// Characters, which are what columns are aligned by.
fn wide(text: &str) -> usize {
    text.chars().count()
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const NAMES: usize = 32;
        let rows = self.rows();
        let widths: Vec<usize> = self
            .cases
            .iter()
            .enumerate()
            .map(|(i, case)| rows.iter().map(|(_, values)| wide(&values[i])).fold(wide(&case.label), usize::max))
            .collect();
        let mut line = |name: &str, values: &mut dyn Iterator<Item = &str>| {
            write!(f, "  {name:<NAMES$}")?;
            for (value, width) in values.zip(&widths) {
                write!(f, "{:indent$}{value}", "", indent = width + 2 - wide(value))?;
            }
            writeln!(f)
        };
        if self.cases.len() > 1 {
            line("", &mut self.cases.iter().map(|case| case.label.as_str()))?;
        }
        for (name, values) in &rows {
            line(name, &mut values.iter().map(String::as_str))?;
        }
        writeln!(f)?;
        match &self.let_off_is {
            Some(what) => writeln!(f, "  Let-off: {what}.")?,
            None => writeln!(f, "  Let-off: not known.")?,
        }
        if self.cases.len() > 1 {
            let how = if self.regulated {
                "regulated again: the hammer rests where it did"
            } else {
                "left as moved: the hammer rests where it will"
            };
            writeln!(f, "  Moved cases are {how}, and is let off at the same height.")?;
            writeln!(f, "  Moves: negative is toward the player, or down.")?;
        }
        if let Some(lengths) = &self.lengths_mm {
            let names = lengths.iter().enumerate().map(|(i, mm)| format!("L{} {mm:.2}", i + 1));
            writeln!(f, "  Nearest lengths (mm): {}.", names.collect::<Vec<_>>().join(", "))?;
            writeln!(
                f,
                "    L7 to L9 are the knuckle's centre, exactly; L2 to L4 take the capstan's dome as touching one point of the heel."
            )?;
        }
        if let Some(dynamics) = &self.dynamics {
            writeln!(
                f,
                "  A slow press of the dynamic model has the same leverage within {:.1} % from key {:.1} to {:.1} mm.",
                dynamics.largest_deviation * 100.0,
                dynamics.from_key_mm,
                dynamics.to_key_mm
            )?;
        }
        for note in &self.notes {
            writeln!(f, "  Note: {note}.")?;
        }
        Ok(())
    }
}
