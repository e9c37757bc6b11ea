//! The action as a picture: outlines that hang on the instrument's geometry, each carried by its body, in one pose.
//!
//! A grand action is drawn by `grand`, a key alone by `lever`, anything else from its contact curves (`fallback`).
//! Outlines that an instrument file brings along come on top, or instead of the latter.

mod anchor;
mod arrows;
mod changed;
mod fallback;
#[cfg(test)]
#[path = "../../tests/common/two_levers.rs"]
pub(crate) mod fixture;
mod force;
mod grand;
mod labels;
mod lever;
mod material;
mod moving;
mod outline;
mod piece;

pub(crate) use arrows::arrows;
pub use changed::ChangedNote;
pub(crate) use changed::changed_marks;
pub(crate) use force::{ARROW, Arrow, arrow_sign, force_label};
pub use force::{ArrowKind, angles_at, forces_at, pins_at};
pub(crate) use labels::named_points;
pub(crate) use material::GRADIENTS;
pub use moving::moving_svg;
pub(crate) use outline::path;
pub(crate) use piece::{Carrier, Piece};

use crate::picture::{Anchor, Carried, Geometry, Group, Head, Look, Node, Paint, Picture, Rule, Shape, Words, css};
use crate::svg::number;
use erard::instrument::{Instrument, Placement};
pub(crate) use outline::MM;
use std::fmt::Write;

/// Additions to the picture of the action.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseOptions {
    /// Width of the picture, or height where that is larger, px.
    pub size_px: f64,
    /// Whether the main parts are named, with leader lines.
    pub labels: bool,
    /// Forces to draw.
    pub arrows: Vec<Arrow>,
    /// Numbers whose notes speak of what they were: marked, and told below the picture.
    pub changed: Vec<ChangedNote>,
    /// A line below the picture, e.g. the instrument's name and the time.
    pub caption: Option<String>,
}

impl Default for PoseOptions {
    fn default() -> Self {
        Self { size_px: 1400.0, labels: false, arrows: Vec::new(), changed: Vec::new(), caption: None }
    }
}

/// The outlines of an instrument.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// In painter's order.
    pub pieces: Vec<Piece>,
    /// Bodies whose pivots are shown.
    pub pins: Vec<usize>,
    /// Bodies that are not shown, for nothing ever moves them: the damper of a note that has none.
    pub unseen: Vec<usize>,
}

/// Draws an instrument from its geometry.
///
/// Outlines of the instrument's own file come on top of a grand action or a key alone, unless the program draws a part
/// of that name, which follows the geometry; of any other mechanism it is the whole picture.
#[must_use]
pub fn drawing(instrument: &Instrument) -> Drawing {
    let all: Vec<usize> = (0..instrument.bodies.len()).collect();
    let own = instrument.parts.iter().map(Piece::of_file);
    let mut drawing = if let Some(grand) = grand::draw(instrument) {
        grand
    } else if let Some(pieces) = lever::draw(instrument) {
        Drawing { pieces, pins: all, unseen: Vec::new() }
    } else {
        let pieces = if instrument.parts.is_empty() { fallback::pieces(instrument) } else { Vec::new() };
        Drawing { pieces, pins: all, unseen: Vec::new() }
    };
    let is_drawn =
        |piece: &Piece| grand::draws(&piece.name) || drawing.pieces.iter().any(|drawn| drawn.name == piece.name);
    let is_known = drawing.pieces.is_empty();
    let own: Vec<Piece> = own.filter(|piece| is_known || !is_drawn(piece)).collect();
    drawing.pieces.extend(own);
    let placed = instrument.drawn();
    drawing.pieces.extend(piece::finger(instrument, &placed));
    drawing
}

/// The style of everything in a picture of the action.
const STYLE: &[Rule] = &[
    Rule::new(&["paper"], &[Look::Fill(Paint::Colour("#faf7f0"))]),
    Rule { within: "parts", classes: &[], looks: &[Look::StrokeWidth(0.45), Look::RoundJoins] },
    Rule::new(
        &["pin"],
        &[Look::Fill(Paint::Colour("#e9e4da")), Look::Stroke(Paint::Colour("#3a3733")), Look::StrokeWidth(0.5)],
    ),
    Rule::new(&["pin-core"], &[Look::Fill(Paint::Colour("#3a3733"))]),
    Rule::new(
        &["arrow"],
        &[
            Look::Fill(Paint::Colour("#d0342c")),
            Look::Stroke(Paint::Colour("#d0342c")),
            Look::StrokeWidth(1.1),
            Look::RoundJoins,
            Look::RoundCaps,
        ],
    ),
    Rule::new(&["arrow", "touch"], &[Look::Fill(Paint::Colour("#1769aa")), Look::Stroke(Paint::Colour("#1769aa"))]),
    Rule::new(
        &["newton"],
        &[
            Look::Fill(Paint::Colour("#b3221b")),
            Look::FontSize(5.0),
            Look::NormalWeight,
            Look::StrokeFirst,
            Look::Stroke(Paint::Colour("#faf7f0")),
            Look::StrokeWidthPx(1.2),
            Look::RoundJoins,
        ],
    ),
    Rule::new(&["newton", "touch"], &[Look::Fill(Paint::Colour("#0d4f85"))]),
    Rule::new(&["arrow", "pin"], &[Look::Fill(Paint::Colour("#6a3d9a")), Look::Stroke(Paint::Colour("#6a3d9a"))]),
    Rule::new(&["newton", "pin"], &[Look::Fill(Paint::Colour("#50287a"))]),
    Rule::new(
        &["mark"],
        &[Look::Fill(Paint::Colour("#fffdf7")), Look::Stroke(Paint::Colour("#b3221b")), Look::StrokeWidth(0.5)],
    ),
    Rule::new(
        &["mark-number"],
        &[Look::Fill(Paint::Colour("#b3221b")), Look::FontSize(4.0), Look::Anchor(Anchor::Middle)],
    ),
    Rule::new(&["changed-note"], &[Look::Fill(Paint::Colour("#b3221b")), Look::FontSize(4.4)]),
    Rule::new(&["leader"], &[Look::Fill(Paint::None), Look::Stroke(Paint::Colour("#5a554e")), Look::StrokeWidth(0.35)]),
    Rule::new(&["leader-end"], &[Look::Fill(Paint::Colour("#5a554e"))]),
    Rule::new(&["label"], &[Look::Fill(Paint::Colour("#2a2723"))]),
    Rule::new(&["caption"], &[Look::Fill(Paint::Colour("#2a2723")), Look::FontSize(6.0)]),
];

/// Height of the line below the picture, mm of the picture.
const CAPTION: f64 = 12.0;

/// What follows each rule of the sheet.
const RULE_END: &str = "\n";

/// The style sheet of a picture of the action, for a page that draws it itself.
pub(crate) fn style() -> String {
    css(STYLE, RULE_END)
}

/// The action with its bodies at the given absolute angles (rad, in the instrument's order; what is missing is drawn
/// as in the file), as a picture.
pub fn pose_picture(instrument: &Instrument, angles_rad: &[f64], options: &PoseOptions) -> Picture {
    let placed = instrument.placements(angles_rad);
    let drawing = drawing(instrument);
    let bounds = view(instrument, &drawing.pieces, &placed);
    let [left, mut top, right, mut bottom] = bounds;
    if options.labels {
        top -= labels::MARGIN;
        bottom += labels::MARGIN;
    }
    let caption_y = bottom + 5.0;
    if options.caption.is_some() {
        bottom += CAPTION;
    }
    let told = changed::lines(&options.changed, right - left - 12.0);
    let told_y = bottom + changed::SIZE;
    if !told.is_empty() {
        bottom += changed::LINE * told.len() as f64 + 5.0;
    }
    let (width, height) = (right - left, bottom - top);
    let pixels = options.size_px / width.max(height);
    let view = [left, top, width, height];
    let head = Head {
        title: instrument.name.clone(),
        size_px: [(pixels * width).round(), (pixels * height).round()],
        view,
        font_size: None,
        style: vec![STYLE],
        rule_end: RULE_END,
        gradients: GRADIENTS,
    };
    let mut nodes = vec![Shape::of_class("paper", Geometry::rect(view))];
    nodes.extend(shapes(&drawing, &placed));
    nodes.extend(changed_marks(instrument, &options.changed, &placed));
    nodes.push(arrows(&options.arrows));
    if options.labels {
        nodes.push(labels::labels(&drawing.pieces, &placed, bounds));
    }
    if let Some(caption) = &options.caption {
        nodes.push(Words::node("caption", [left + 6.0, caption_y], [], caption));
    }
    for (index, line) in told.iter().enumerate() {
        let place = [left + 6.0, told_y + changed::LINE * index as f64];
        nodes.push(Words::node("changed-note", place, [], line));
    }
    Picture { head, nodes }
}

/// A picture for a page that may be dark: where the page is, its paper is dark and its words are light, as in the page
/// of a run; the parts keep their colours.
#[must_use]
pub fn at_night(svg: &str) -> String {
    svg.replacen("</style>", &format!("{NIGHT}</style>"), 1)
}

const NIGHT: &str = "@media (prefers-color-scheme:dark){.paper{fill:#26272b}.label,.caption{fill:#e9e6e0}.leader{stroke:#a8a39a}\
.leader-end{fill:#a8a39a}.newton{fill:#fff;stroke:#1b1214}.changed-note{fill:#ff8a7d}}";

/// Pieces and pins, each piece in its carrier's frame. In the SVG `data-body` says which body moves it; with
/// `data-point` it follows that point of the body (mm, as written) from where it is as drawn (`data-drawn`) without
/// turning, with `data-guided` up and down only. `data-rail` says that the sustain pedal lifts it.
pub(crate) fn shapes(drawing: &Drawing, placed: &[Placement]) -> [Node; 2] {
    shapes_carried(drawing, &|carrier| carried(carrier, placed))
}

/// Pieces and pins, carried as the caller says.
fn shapes_carried(drawing: &Drawing, carried: &dyn Fn(&Carrier) -> Carried) -> [Node; 2] {
    let part = |piece: &Piece| {
        let outline = path(piece);
        let carried = carried(&piece.carrier);
        (!outline.is_empty()).then(|| Shape::part(outline, material::looks(piece.finish), carried, &piece.name))
    };
    let pin = |body: &usize| {
        let nodes = [("pin", 1.5), ("pin-core", 0.5)]
            .map(|(class, radius)| Shape::of_class(class, Geometry::Circle(None, radius)));
        let carried = carried(&Carrier::Body(*body));
        Node::Group(Group { carried, nodes: nodes.into(), ..Group::default() })
    };
    let parts = drawing.pieces.iter().filter_map(part).collect();
    let pins = drawing.pins.iter().map(pin).collect();
    [("parts", parts), ("pins", pins)].map(|(class, nodes)| Node::Group(Group { class, nodes, ..Group::default() }))
}

pub(super) fn carried(carrier: &Carrier, placed: &[Placement]) -> Carried {
    let Some(body) = carrier.body() else {
        let data = if *carrier == Carrier::Rail { " data-rail=\"\"" } else { "" };
        return Carried { data: data.to_owned(), turn: None };
    };
    let mut data = format!(" data-body=\"{body}\"");
    if let Carrier::Point { point_m, drawn_m, is_guided, .. } = carrier {
        let pair = |[x, y]: [f64; 2]| format!("{} {}", number(x * MM), number(y * MM));
        let _ = write!(data, " data-point=\"{}\" data-drawn=\"{}\"", pair(*point_m), pair(*drawn_m));
        if *is_guided {
            data.push_str(" data-guided=\"\"");
        }
    }
    Carried { data, turn: Some(outline::turn(&carrier.placement(placed))) }
}

/// `[left, top, right, bottom]` in picture millimetres, with a margin, holding the pieces both in this pose and as
/// drawn, so that pictures of neighbouring poses match.
pub(crate) fn view(instrument: &Instrument, pieces: &[Piece], placed: &[Placement]) -> [f64; 4] {
    const MARGIN: f64 = 8.0;
    let drawn = instrument.drawn();
    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for frames in [placed, &drawn] {
        for piece in pieces {
            let frame = piece.carrier.placement(frames);
            for &point in piece.outline_m.iter().filter(|p| p.iter().all(|c| c.is_finite())) {
                let [x, y] = frame.to_world(point).map(|c| c * MM);
                bounds = [bounds[0].min(x), bounds[1].min(-y), bounds[2].max(x), bounds[3].max(-y)];
            }
        }
    }
    if bounds[0] > bounds[2] {
        bounds = [-50.0, -50.0, 50.0, 50.0];
    }
    [bounds[0] - MARGIN, bounds[1] - MARGIN, bounds[2] + MARGIN, bounds[3] + MARGIN]
}

#[cfg(test)]
mod tests {
    use super::*;
    use erard::instrument::{InstrumentFields, Roles};

    #[test]
    fn names_from_files_are_escaped() {
        let instrument = fixture::two_levers_drawn();
        let options = PoseOptions { labels: true, caption: Some("</svg>".into()), ..PoseOptions::default() };
        let svg = pose_picture(&instrument, &[], &options).svg();
        assert!(!svg.contains("</script>") && !svg.contains("<b>") && !svg.contains("<levers>"));
        assert_eq!(svg.matches("</svg>").count(), 1);
    }

    #[test]
    fn the_same_pose_gives_the_same_bytes() {
        let instrument = fixture::two_levers_drawn();
        let options = PoseOptions::default();
        let svg = || pose_picture(&instrument, &[0.2, 0.3], &options).svg();
        assert_eq!(svg(), svg());
    }

    /// An instrument without parts, without bodies even, still gives a document.
    #[test]
    fn nothing_to_draw_is_still_a_picture() {
        let mut instrument = fixture::two_levers();
        assert!(pose_picture(&instrument, &[], &PoseOptions::default()).svg().contains("made up"));
        let bare = InstrumentFields {
            bodies: Vec::new(),
            springs: Vec::new(),
            zones: Vec::new(),
            roles: Roles::default(),
            parts: Vec::new(),
            ..(*instrument).clone()
        };
        instrument = Instrument::new(bare).unwrap();
        assert!(!pose_picture(&instrument, &[], &PoseOptions::default()).svg().contains("inf"));
    }
}
