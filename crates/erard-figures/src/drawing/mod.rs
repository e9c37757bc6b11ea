//! The action as a picture: the instrument's parts, each carried by its body, in one pose.

#[cfg(test)]
mod agreement;
mod anchor;
mod fallback;
#[cfg(test)]
pub(crate) mod fixture;
mod force;
mod labels;
mod material;
mod outline;
mod pose;

pub use force::{ARROW, ArrowLaw, ContactForce, angles_at, arrow_sign, arrows, force_label, forces_at};
pub use material::{Paint, gradients, paint};
pub use outline::{path, transform};
pub use pose::{Placement, carrier, drawn_angles, placements};

use crate::svg::{escape, number};
use erard::instrument::{Instrument, Part};
pub(crate) use outline::MM;
use std::borrow::Cow;
use std::fmt::Write;

/// The fonts asked for, the one bundled for PNGs first.
pub const FONTS: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

/// What to show beside the wood.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseOptions {
    /// Width of the picture, or height where that is larger, px.
    pub size_px: f64,
    /// Whether the main parts are named, with leader lines.
    pub labels: bool,
    /// Contact forces to draw as arrows.
    pub forces: Vec<ContactForce>,
    /// A line below the picture, e.g. the instrument's name and the time.
    pub caption: Option<String>,
}

impl Default for PoseOptions {
    fn default() -> Self {
        Self { size_px: 1400.0, labels: false, forces: Vec::new(), caption: None }
    }
}

/// The instrument's parts, or made-up ones where its file draws none.
pub fn parts(instrument: &Instrument) -> Cow<'_, [Part]> {
    if instrument.parts.is_empty() { Cow::Owned(fallback::parts(instrument)) } else { Cow::Borrowed(&instrument.parts) }
}

/// The style of everything in a picture of the action; the page inlines the same.
pub const STYLE: &str = include_str!("drawing.css");

/// The action with its bodies at the given absolute angles (rad, in the instrument's order; what is missing is drawn
/// as in the file), as an SVG document.
pub fn pose_svg(instrument: &Instrument, angles_rad: &[f64], options: &PoseOptions) -> String {
    let placed = placements(instrument, angles_rad);
    let parts = parts(instrument);
    let bounds = view(instrument, &parts, &placed);
    let [left, mut top, right, mut bottom] = bounds;
    if options.labels {
        top -= labels::MARGIN;
        bottom += labels::MARGIN;
    }
    let caption_y = bottom + 5.0;
    if options.caption.is_some() {
        bottom += 12.0;
    }
    let (width, height) = (right - left, bottom - top);
    let pixels = options.size_px / width.max(height);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"{} {} {} {}\" \
         font-family=\"{FONTS}\" role=\"img\"><title>{}</title><style>{STYLE}</style><defs>{}</defs>\
         <rect class=\"paper\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
        number((pixels * width).round()),
        number((pixels * height).round()),
        number(left),
        number(top),
        number(width),
        number(height),
        escape(&instrument.name),
        gradients(),
        number(left),
        number(top),
        number(width),
        number(height),
    );
    out.push_str(&shapes(instrument, &parts, &placed));
    out.push_str(&arrows(&options.forces));
    if options.labels {
        out.push_str(&labels::labels(&parts, &placed, bounds));
    }
    if let Some(caption) = &options.caption {
        let _ = write!(
            out,
            "<text class=\"caption\" x=\"{}\" y=\"{}\">{}</text>",
            number(left + 6.0),
            number(caption_y),
            escape(caption)
        );
    }
    out.push_str("</svg>\n");
    out
}

/// Parts and pins as SVG elements, each part in its body's frame: `data-body` says which frame moves it.
pub fn shapes(instrument: &Instrument, parts: &[Part], placed: &[Placement]) -> String {
    let mut out = String::from("<g class=\"parts\">");
    for part in parts {
        let drawn = path(part);
        if drawn.is_empty() {
            continue;
        }
        let paint = paint(part.material);
        let _ = write!(
            out,
            "<path d=\"{drawn}\" fill=\"url(#{})\" stroke=\"{}\"{}><title>{}</title></path>",
            paint.id,
            paint.edge,
            carried(part.body, placed),
            escape(&part.name)
        );
    }
    out.push_str("</g><g class=\"pins\">");
    for index in 0..instrument.bodies.len() {
        let _ = write!(
            out,
            "<g{}><circle class=\"pin\" r=\"1.5\"/><circle class=\"pin-core\" r=\"0.5\"/></g>",
            carried(Some(index), placed)
        );
    }
    out.push_str("</g>");
    out
}

fn carried(body: Option<usize>, placed: &[Placement]) -> String {
    body.map_or(String::new(), |index| format!(" data-body=\"{index}\" transform=\"{}\"", transform(&placed[index])))
}

/// `[left, top, right, bottom]` in picture millimetres, with a margin, holding the parts both in this pose and as
/// drawn, so that pictures of neighbouring poses match.
pub fn view(instrument: &Instrument, parts: &[Part], placed: &[Placement]) -> [f64; 4] {
    const MARGIN: f64 = 8.0;
    let drawn = placements(instrument, &drawn_angles(instrument));
    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for frames in [placed, &drawn] {
        for part in parts {
            let frame = carrier(frames, part.body);
            for &point in part.outline_m.iter().filter(|p| p.iter().all(|c| c.is_finite())) {
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
