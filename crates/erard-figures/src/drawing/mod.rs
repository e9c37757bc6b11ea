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
mod outline;
mod piece;

pub use arrows::{ArrowKind, arrows};

pub(crate) use arrows::Arrow;
pub use changed::ChangedNote;
pub(crate) use changed::changed_marks;
pub(crate) use force::{ARROW, arrow_sign, force_label};
pub use force::{angles_at, forces_at, pins_at};
pub(crate) use labels::named_points;
pub(crate) use material::{gradients, paint};
pub(crate) use outline::{path, transform};
pub(crate) use piece::{Carrier, Piece};

use crate::svg::{escape, number, sides, text};
use erard::instrument::{Instrument, Placement};
pub(crate) use outline::MM;
use std::fmt::Write;

/// The fonts asked for, the one bundled for PNGs first.
pub(crate) const FONTS: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

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

/// The style of everything in a picture of the action; the page inlines the same.
pub(crate) const STYLE: &str = include_str!("drawing.css");

/// The action with its bodies at the given absolute angles (rad, in the instrument's order; what is missing is drawn
/// as in the file), as an SVG document.
pub fn pose_svg(instrument: &Instrument, angles_rad: &[f64], options: &PoseOptions) -> String {
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
        bottom += 12.0;
    }
    let told = changed::lines(&options.changed, right - left - 12.0);
    let told_y = bottom + changed::SIZE;
    if !told.is_empty() {
        bottom += changed::LINE * told.len() as f64 + 5.0;
    }
    let (width, height) = (right - left, bottom - top);
    let pixels = options.size_px / width.max(height);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"{} {} {} {}\" \
         font-family=\"{FONTS}\" role=\"img\"><title>{}</title><style>{STYLE}</style><defs>{}</defs>\
         <rect class=\"paper\"{}/>",
        number((pixels * width).round()),
        number((pixels * height).round()),
        number(left),
        number(top),
        number(width),
        number(height),
        escape(&instrument.name),
        gradients(),
        sides([left, top, width, height]),
    );
    out.push_str(&shapes(&drawing, &placed));
    out.push_str(&changed_marks(instrument, &options.changed, &placed));
    out.push_str(&arrows(&options.arrows));
    if options.labels {
        out.push_str(&labels::labels(&drawing.pieces, &placed, bounds));
    }
    if let Some(caption) = &options.caption {
        text(&mut out, "caption", [left + 6.0, caption_y], "", caption);
    }
    for (index, line) in told.iter().enumerate() {
        text(&mut out, "changed-note", [left + 6.0, told_y + changed::LINE * index as f64], "", line);
    }
    out.push_str("</svg>\n");
    out
}

/// A picture for a page that may be dark: where the page is, its paper is dark and its words are light, as in the page
/// of a run; the parts keep their colours.
#[must_use]
pub fn at_night(svg: &str) -> String {
    svg.replacen("</style>", &format!("{NIGHT}</style>"), 1)
}

const NIGHT: &str = "@media (prefers-color-scheme:dark){.paper{fill:#26272b}.label,.caption{fill:#e9e6e0}.leader{stroke:#a8a39a}\
.leader-end{fill:#a8a39a}.newton{fill:#fff;stroke:#1b1214}.changed-note{fill:#ff8a7d}}";

/// Pieces and pins as SVG elements, each piece in its carrier's frame. `data-body` says which body moves it; with
/// `data-point` it follows that point of the body (mm, as written) from where it is as drawn (`data-drawn`) without
/// turning, with `data-guided` up and down only. `data-rail` says that the sustain pedal lifts it.
pub(crate) fn shapes(drawing: &Drawing, placed: &[Placement]) -> String {
    let mut out = String::from("<g class=\"parts\">");
    for piece in &drawing.pieces {
        let drawn = path(piece);
        if drawn.is_empty() {
            continue;
        }
        let paint = paint(piece.finish);
        let _ = write!(
            out,
            "<path d=\"{drawn}\" fill=\"url(#{})\" stroke=\"{}\"{}><title>{}</title></path>",
            paint.id,
            paint.edge,
            carried(&piece.carrier, placed),
            escape(&piece.name)
        );
    }
    out.push_str("</g><g class=\"pins\">");
    for &body in &drawing.pins {
        let _ = write!(
            out,
            "<g{}><circle class=\"pin\" r=\"1.5\"/><circle class=\"pin-core\" r=\"0.5\"/></g>",
            carried(&Carrier::Body(body), placed)
        );
    }
    out.push_str("</g>");
    out
}

pub(super) fn carried(carrier: &Carrier, placed: &[Placement]) -> String {
    let Some(body) = carrier.body() else {
        return String::from(if *carrier == Carrier::Rail { " data-rail=\"\"" } else { "" });
    };
    let mut out = format!(" data-body=\"{body}\"");
    if let Carrier::Point { point_m, drawn_m, is_guided, .. } = carrier {
        let pair = |[x, y]: [f64; 2]| format!("{} {}", number(x * MM), number(y * MM));
        let _ = write!(out, " data-point=\"{}\" data-drawn=\"{}\"", pair(*point_m), pair(*drawn_m));
        if *is_guided {
            out.push_str(" data-guided=\"\"");
        }
    }
    let _ = write!(out, " transform=\"{}\"", transform(&carrier.placement(placed)));
    out
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

    #[test]
    fn names_from_files_are_escaped() {
        let instrument = fixture::two_levers_drawn();
        let options = PoseOptions { labels: true, caption: Some("</svg>".into()), ..PoseOptions::default() };
        let svg = pose_svg(&instrument, &[], &options);
        assert!(!svg.contains("</script>") && !svg.contains("<b>") && !svg.contains("<levers>"));
        assert_eq!(svg.matches("</svg>").count(), 1);
    }

    #[test]
    fn the_same_pose_gives_the_same_bytes() {
        let instrument = fixture::two_levers_drawn();
        let options = PoseOptions::default();
        assert_eq!(pose_svg(&instrument, &[0.2, 0.3], &options), pose_svg(&instrument, &[0.2, 0.3], &options));
    }

    /// An instrument without parts, without bodies even, still gives a document.
    #[test]
    fn nothing_to_draw_is_still_a_picture() {
        let mut instrument = fixture::two_levers();
        assert!(pose_svg(&instrument, &[], &PoseOptions::default()).contains("made up"));
        instrument.bodies.clear();
        instrument.zones.clear();
        assert!(!pose_svg(&instrument, &[], &PoseOptions::default()).contains("inf"));
    }
}
