//! The force curves that come with the program: five nuances, pressed and struck, for tests and comparisons. An earlier
//! model of a hand played them on the concert grand; the built-in touches are hands ([`crate::level`]).

use super::{STRUCK_JOINTS, Series};
use crate::player::Joints;

/// Nuances, softest first.
pub const NUANCES: [&str; 5] = ["pp", "p", "mf", "f", "ff"];

/// Way in which the hand meets the key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Touch {
    /// The hand rests on the key and presses it.
    Pressed,
    /// The hand arrives at the key with speed.
    Struck,
}

impl Touch {
    /// Its name in titles and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Touch::Pressed => "pressed",
            Touch::Struck => "struck",
        }
    }

    /// Joints of the finger of the built-in touch ([`super::STRUCK_JOINTS`]); stiff where it presses.
    pub fn joints(self) -> Joints {
        match self {
            Touch::Pressed => Joints::STIFF,
            Touch::Struck => STRUCK_JOINTS,
        }
    }
}

macro_rules! strokes {
    ($nuance:expr, $touch:expr, $folder:literal) => {{
        macro_rules! stroke {
            ($name:literal) => {
                include_str!(concat!("../../", $folder, "/", $name, ".csv"))
            };
        }
        Some(match ($nuance, $touch) {
            ("pp", Touch::Pressed) => stroke!("pp-pressed"),
            ("p", Touch::Pressed) => stroke!("p-pressed"),
            ("mf", Touch::Pressed) => stroke!("mf-pressed"),
            ("f", Touch::Pressed) => stroke!("f-pressed"),
            ("ff", Touch::Pressed) => stroke!("ff-pressed"),
            ("pp", Touch::Struck) => stroke!("pp-struck"),
            ("p", Touch::Struck) => stroke!("p-struck"),
            ("mf", Touch::Struck) => stroke!("mf-struck"),
            ("f", Touch::Struck) => stroke!("f-struck"),
            ("ff", Touch::Struck) => stroke!("ff-struck"),
            _ => return None,
        })
    }};
}

impl Series {
    /// A built-in stroke; `None` if there is no such nuance.
    pub fn builtin(nuance: &str, touch: Touch) -> Option<Self> {
        // A test reads them all.
        Series::parse(Self::builtin_text(nuance, touch)?, nuance).ok()
    }

    /// The text of a built-in stroke's file.
    pub fn builtin_text(nuance: &str, touch: Touch) -> Option<&'static str> {
        strokes!(nuance, touch, "strokes")
    }

    /// The stroke that belongs to `concert-grand-rigid`: a force that is a formula, and the position that the key of
    /// six rigid bodies has under it. The built-in strokes of before the grand bent; what was published with it stays
    /// as it was.
    pub fn rigid(nuance: &str, touch: Touch) -> Option<Self> {
        Series::parse(strokes!(nuance, touch, "rigid-strokes")?, nuance).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All ten are there, with force and position.
    #[test]
    fn all_are_readable() {
        for nuance in NUANCES {
            for touch in [Touch::Pressed, Touch::Struck] {
                let stroke = Series::builtin(nuance, touch).expect(nuance);
                assert!(stroke.force.is_some() && stroke.position.is_some(), "{nuance} {touch:?}");
                let rigid = Series::rigid(nuance, touch).expect(nuance);
                assert!(rigid.force.is_some() && rigid.position.is_some() && rigid != stroke, "{nuance} {touch:?}");
            }
        }
        assert!(Series::builtin("mp", Touch::Pressed).is_none());
    }
}
