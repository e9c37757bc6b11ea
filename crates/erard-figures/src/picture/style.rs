//! The looks of shapes and words, as attributes of one and as rules for all of a class.

/// A property.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Look {
    Fill(Paint),
    FillOpacity(f64),
    Stroke(Paint),
    StrokeWidth(f64),
    /// A width with its unit, which words of a page need.
    StrokeWidthPx(f64),
    /// A dash and the gap after it.
    Dashes([f64; 2]),
    RoundJoins,
    RoundCaps,
    /// The edge is drawn before the inside, which so stays whole.
    StrokeFirst,
    /// Height of letters, px or units of the picture.
    FontSize(f64),
    /// Against a page's bold words.
    NormalWeight,
    Anchor(Anchor),
}

/// What an inside or an edge is filled with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Paint {
    None,
    /// `#rgb` or `#rrggbb`.
    Colour(&'static str),
    /// From 0, black, to 255.
    Grey(u8),
    /// One of the picture's gradients, by its identifier.
    Gradient(&'static str),
}

/// What of words stands at their place, where it is not their start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Middle,
    End,
}

/// A rule of a style sheet: how all shapes and words of some classes look. Later rules win over earlier ones, so rules
/// for more classes come after those for one.
#[derive(Debug, PartialEq)]
pub(crate) struct Rule {
    /// The class of the group whose paths it is about; of any where empty.
    pub within: &'static str,
    /// The classes that a shape must have, all of them.
    pub classes: &'static [&'static str],
    pub looks: &'static [Look],
}

impl Rule {
    pub(crate) const fn new(classes: &'static [&'static str], looks: &'static [Look]) -> Self {
        Rule { within: "", classes, looks }
    }

    /// Whether it is about a shape of some classes in a group of a class.
    #[cfg(feature = "png")]
    pub(crate) fn is_about(&self, within: &str, classes: &str) -> bool {
        (self.within.is_empty() || self.within == within)
            && self.classes.iter().all(|class| classes.split(' ').any(|one| one == *class))
    }
}

/// A gradient from a shape's upper edge to its lower one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Gradient {
    pub id: &'static str,
    /// Colour at the upper edge, `#rrggbb`.
    pub upper: &'static str,
    /// Colour at the lower edge.
    pub lower: &'static str,
}
