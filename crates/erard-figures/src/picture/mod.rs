//! A picture as data: shapes, words and groups of them, written as SVG or painted as PNG.
//!
//! The style sheet is data too ([`Rule`]), so that both writers read the same one.

#[cfg(feature = "png")]
mod face;
#[cfg(feature = "png")]
mod png;
mod style;
mod svg;

#[cfg(feature = "png")]
pub use png::PngError;
pub(crate) use style::{Anchor, Gradient, Look, Paint, Rule};
#[cfg(test)]
pub(crate) use svg::path;
pub(crate) use svg::{css, gradients, nodes};

use std::borrow::Cow;

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    pub(crate) head: Head,
    /// In painter's order: later nodes cover earlier ones.
    pub(crate) nodes: Vec<Node>,
}

impl Picture {
    /// The picture as an SVG document. The same picture gives the same bytes.
    #[must_use]
    pub fn svg(&self) -> String {
        svg::document(self)
    }

    /// The picture on white as a PNG with so many pixels per SVG pixel. The same picture gives the same bytes.
    ///
    /// Words are drawn in DejaVu Sans, from left to right.
    ///
    /// # Errors
    /// [`PngError::Size`] where a side would have no pixel or more than 16384.
    #[cfg(feature = "png")]
    pub fn png(&self, scale: f64) -> Result<Vec<u8>, PngError> {
        png::png(self, scale)
    }
}

/// What stands at the head of a document.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Head {
    /// Text for readers who cannot see the picture.
    pub title: String,
    /// Width and height, px.
    pub size_px: [f64; 2],
    /// What of the plane is shown: left, top, width and height.
    pub view: [f64; 4],
    /// Size of letters where nothing else is said.
    pub font_size: Option<u8>,
    /// The style sheet, in several parts.
    pub style: Vec<&'static [Rule]>,
    /// What follows each rule of the sheet.
    pub rule_end: &'static str,
    /// Gradients that the picture may use.
    pub gradients: &'static [Gradient],
}

/// A node of a picture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Node {
    Group(Group),
    /// A clip path, before the groups that it clips.
    Clip(Clip),
    Shape(Shape),
    Words(Words),
}

/// Nodes that are moved, clipped or styled as one.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Group {
    /// Its class; may be empty.
    pub class: &'static str,
    pub clip: Option<Clip>,
    pub carried: Carried,
    pub nodes: Vec<Node>,
}

/// An upright rectangle outside of which nothing is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Clip {
    /// Its name, unique within a page.
    pub id: String,
    /// Left, top, width and height.
    pub area: [f64; 4],
}

/// How something is carried by a moving body.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Carried {
    /// Attributes for the script of a page, each after a space.
    pub data: String,
    /// Where it is now.
    pub turn: Option<Turn>,
}

/// A shift, after a turn about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turn {
    pub to: [f64; 2],
    /// Clockwise.
    pub degrees: f64,
}

/// A shape.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shape {
    /// Its classes, a space between two; may be empty.
    pub class: Cow<'static, str>,
    /// Attributes written before the geometry.
    pub before: Vec<Look>,
    pub geometry: Geometry,
    /// Attributes written after it.
    pub after: Vec<Look>,
    pub carried: Carried,
    /// Its name for a pointer that rests on it.
    pub title: Option<String>,
}

impl Shape {
    pub(crate) fn new(class: impl Into<Cow<'static, str>>, geometry: Geometry) -> Self {
        Shape {
            class: class.into(),
            before: Vec::new(),
            geometry,
            after: Vec::new(),
            carried: Carried::default(),
            title: None,
        }
    }

    /// A shape whose class says what it looks like.
    pub(crate) fn of_class(class: impl Into<Cow<'static, str>>, geometry: Geometry) -> Node {
        Node::Shape(Shape::new(class, geometry))
    }

    /// A shape, then what it looks like.
    pub(crate) fn with(geometry: Geometry, after: Vec<Look>) -> Node {
        Node::Shape(Shape { after, ..Shape::new("", geometry) })
    }

    /// What a shape looks like, then the shape.
    pub(crate) fn looking(before: Vec<Look>, geometry: Geometry) -> Node {
        Node::Shape(Shape { before, ..Shape::new("", geometry) })
    }

    /// A part of the action: outline, looks, the body that carries it, name.
    pub(crate) fn part(outline: Vec<Segment>, after: Vec<Look>, carried: Carried, title: &str) -> Node {
        let title = Some(title.to_owned());
        Node::Shape(Shape { after, carried, title, ..Shape::new("", Geometry::Path(outline)) })
    }
}

/// Geometry of a shape.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Geometry {
    Line([[f64; 2]; 2]),
    /// Left upper corner, and width and height; without a corner it is that of the picture.
    Rect(Option<[f64; 2]>, [f64; 2]),
    /// Center, at the origin where there is none, and radius.
    Circle(Option<[f64; 2]>, f64),
    Polyline(Vec<[f64; 2]>),
    Polygon(Vec<[f64; 2]>),
    Path(Vec<Segment>),
    /// Many upright rectangles as one path: left, top, width and height.
    Cells(Vec<[f64; 4]>),
}

impl Geometry {
    /// An upright rectangle: left, top, width and height.
    pub(crate) fn rect([left, top, width, height]: [f64; 4]) -> Self {
        Geometry::Rect(Some([left, top]), [width, height])
    }
}

/// A segment of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Segment {
    Move([f64; 2]),
    Line([f64; 2]),
    /// Straight up or down, to this ordinate.
    Vertical(f64),
    /// Control point and end.
    Quad([f64; 2], [f64; 2]),
    Close,
}

/// Words at a place.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Words {
    /// Its classes, a space between two.
    pub class: Cow<'static, str>,
    /// Where the base line begins, or has its middle or end.
    pub at: [f64; 2],
    pub looks: Vec<Look>,
    /// Whether they run upwards, turned about their place.
    pub upwards: bool,
    pub text: String,
}

impl Words {
    pub(crate) fn node(
        class: impl Into<Cow<'static, str>>,
        at: [f64; 2],
        looks: impl Into<Vec<Look>>,
        text: &str,
    ) -> Node {
        Node::Words(Words { class: class.into(), at, looks: looks.into(), upwards: false, text: text.to_owned() })
    }

    /// Words that run upwards.
    pub(crate) fn upwards(
        class: impl Into<Cow<'static, str>>,
        at: [f64; 2],
        looks: impl Into<Vec<Look>>,
        text: &str,
    ) -> Node {
        Node::Words(Words { class: class.into(), at, looks: looks.into(), upwards: true, text: text.to_owned() })
    }
}
