//! A picture as an SVG document.

use super::style::{Anchor, Gradient, Look, Paint, Rule};
use super::{Carried, Clip, Geometry, Group, Node, Picture, Segment, Shape, Words};
use crate::svg::{escape, number, sides};
use std::fmt::Write;

/// Fonts for viewers of SVG, the one bundled for PNG first.
const FONTS: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

/// Whether a property is written as an attribute or in a style sheet.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Attribute,
    Declaration,
}

pub(super) fn document(picture: &Picture) -> String {
    let head = &picture.head;
    let [width, height] = head.size_px.map(number);
    let [left, top, wide, tall] = head.view.map(number);
    let font_size = head.font_size.map_or(String::new(), |size| format!(" font-size=\"{size}\""));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"{left} {top} {wide} {tall}\" font-family=\"{FONTS}\"{font_size} role=\"img\"><title>{}</title>",
        escape(&head.title),
    );
    if !head.style.is_empty() {
        let style: String = head.style.iter().map(|rules| css(rules, head.rule_end)).collect();
        let _ = write!(out, "<style>{style}</style>");
    }
    if !head.gradients.is_empty() {
        let _ = write!(out, "<defs>{}</defs>", gradients(head.gradients));
    }
    write_nodes(&mut out, &picture.nodes);
    out.push_str("</svg>\n");
    out
}

/// Nodes as SVG elements.
pub(crate) fn nodes(nodes: &[Node]) -> String {
    let mut out = String::new();
    write_nodes(&mut out, nodes);
    out
}

fn write_nodes(out: &mut String, nodes: &[Node]) {
    for node in nodes {
        match node {
            Node::Group(group) => write_group(out, group),
            Node::Clip(Clip { id, area }) => {
                let _ = write!(out, "<clipPath id=\"{id}\"><rect{}/></clipPath>", sides(*area));
            }
            Node::Shape(shape) => write_shape(out, shape),
            Node::Words(words) => write_words(out, words),
        }
    }
}

fn write_group(out: &mut String, Group { class, clip, carried, nodes }: &Group) {
    out.push_str("<g");
    write_class(out, class);
    if let Some(Clip { id, .. }) = clip {
        let _ = write!(out, " clip-path=\"url(#{id})\"");
    }
    write_carried(out, carried);
    out.push('>');
    write_nodes(out, nodes);
    out.push_str("</g>");
}

fn write_shape(out: &mut String, shape: &Shape) {
    let tag = match shape.geometry {
        Geometry::Line(_) => "line",
        Geometry::Rect(..) => "rect",
        Geometry::Circle(..) => "circle",
        Geometry::Polyline(_) => "polyline",
        Geometry::Polygon(_) => "polygon",
        Geometry::Path(_) | Geometry::Cells(_) => "path",
    };
    let _ = write!(out, "<{tag}");
    write_class(out, &shape.class);
    shape.before.iter().for_each(|look| write_attribute(out, look));
    write_geometry(out, &shape.geometry);
    shape.after.iter().for_each(|look| write_attribute(out, look));
    write_carried(out, &shape.carried);
    match &shape.title {
        Some(title) => {
            let _ = write!(out, "><title>{}</title></{tag}>", escape(title));
        }
        None => out.push_str("/>"),
    }
}

fn write_words(out: &mut String, Words { class, at, looks, upwards, text }: &Words) {
    out.push_str("<text");
    write_class(out, class);
    let [x, y] = at.map(number);
    let _ = write!(out, " x=\"{x}\" y=\"{y}\"");
    looks.iter().for_each(|look| write_attribute(out, look));
    if *upwards {
        let _ = write!(out, " transform=\"rotate(-90 {x} {y})\"");
    }
    let _ = write!(out, ">{}</text>", escape(text));
}

fn write_class(out: &mut String, class: &str) {
    if !class.is_empty() {
        let _ = write!(out, " class=\"{class}\"");
    }
}

fn write_carried(out: &mut String, Carried { data, turn }: &Carried) {
    out.push_str(data);
    if let Some(turn) = turn {
        let [x, y] = turn.to.map(number);
        let _ = write!(out, " transform=\"translate({x} {y}) rotate({})\"", number(turn.degrees));
    }
}

fn write_attribute(out: &mut String, look: &Look) {
    let (name, value) = property(look, Form::Attribute);
    let _ = write!(out, " {name}=\"{value}\"");
}

fn write_geometry(out: &mut String, geometry: &Geometry) {
    let _ = match geometry {
        Geometry::Line([from, to]) => {
            let ([x1, y1], [x2, y2]) = (from.map(number), to.map(number));
            write!(out, " x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"")
        }
        Geometry::Rect(Some([left, top]), [width, height]) => {
            out.push_str(&sides([*left, *top, *width, *height]));
            Ok(())
        }
        Geometry::Rect(None, size) => {
            let [width, height] = size.map(number);
            write!(out, " width=\"{width}\" height=\"{height}\"")
        }
        Geometry::Circle(center, radius) => {
            if let Some([x, y]) = center.map(|center| center.map(number)) {
                let _ = write!(out, " cx=\"{x}\" cy=\"{y}\"");
            }
            write!(out, " r=\"{}\"", number(*radius))
        }
        Geometry::Polyline(points) | Geometry::Polygon(points) => {
            out.push_str(" points=\"");
            for (index, point) in points.iter().enumerate() {
                let ([x, y], gap) = (point.map(number), if index == 0 { "" } else { " " });
                let _ = write!(out, "{gap}{x},{y}");
            }
            write!(out, "\"")
        }
        Geometry::Path(segments) => write!(out, " d=\"{}\"", path(segments)),
        Geometry::Cells(cells) => {
            out.push_str(" d=\"");
            for [x, y, w, h] in cells {
                let _ = write!(out, "M{x:.1} {y:.2}h{w:.2}v{h:.2}h-{w:.2}z");
            }
            write!(out, "\"")
        }
    };
}

/// Segments as the text of a path.
pub(crate) fn path(segments: &[Segment]) -> String {
    let mut out = String::new();
    for segment in segments {
        let pair = |point: &[f64; 2]| format!("{} {}", number(point[0]), number(point[1]));
        let _ = match segment {
            Segment::Move(to) => write!(out, "M{}", pair(to)),
            Segment::Line(to) => write!(out, "L{}", pair(to)),
            Segment::Vertical(y) => write!(out, "V{}", number(*y)),
            Segment::Quad(control, to) => write!(out, "Q{} {}", pair(control), pair(to)),
            Segment::Close => write!(out, "Z"),
        };
    }
    out
}

/// Rules as a style sheet, `end` after each.
pub(crate) fn css(rules: &[Rule], end: &str) -> String {
    let mut out = String::new();
    for Rule { within, classes, looks } in rules {
        if within.is_empty() {
            classes.iter().for_each(|class| out.extend([".", class]));
        } else {
            let _ = write!(out, ".{within} path");
        }
        let declarations: Vec<String> = looks
            .iter()
            .map(|look| {
                let (name, value) = property(look, Form::Declaration);
                format!("{name}:{value}")
            })
            .collect();
        let _ = write!(out, "{{{}}}{end}", declarations.join(";"));
    }
    out
}

/// A property's name and value.
fn property(look: &Look, form: Form) -> (&'static str, String) {
    match look {
        Look::Fill(paint) => ("fill", paint_value(paint)),
        Look::FillOpacity(share) => ("fill-opacity", short(*share)),
        Look::Stroke(paint) => ("stroke", paint_value(paint)),
        Look::StrokeWidth(width) => ("stroke-width", short(*width)),
        Look::StrokeWidthPx(width) => ("stroke-width", format!("{}px", short(*width))),
        Look::Dashes([dash, gap]) => ("stroke-dasharray", format!("{} {}", short(*dash), short(*gap))),
        Look::RoundJoins => ("stroke-linejoin", "round".into()),
        Look::RoundCaps => ("stroke-linecap", "round".into()),
        Look::StrokeFirst => ("paint-order", "stroke".into()),
        Look::FontSize(size) => {
            ("font-size", format!("{}{}", short(*size), if form == Form::Declaration { "px" } else { "" }))
        }
        Look::NormalWeight => ("font-weight", "normal".into()),
        Look::Anchor(anchor) => {
            let value = match anchor {
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            ("text-anchor", value.into())
        }
    }
}

fn paint_value(paint: &Paint) -> String {
    match paint {
        Paint::None => "none".into(),
        Paint::Colour(colour) => escape(colour),
        Paint::Grey(grey) => format!("#{grey:02x}{grey:02x}{grey:02x}"),
        Paint::Gradient(id) => format!("url(#{id})"),
    }
}

/// A number without the zero before its point.
fn short(value: f64) -> String {
    let text = number(value);
    text.strip_prefix("0.").map_or(text.clone(), |decimals| format!(".{decimals}"))
}

/// Gradients, for a document's `<defs>`.
pub(crate) fn gradients(gradients: &[Gradient]) -> String {
    let mut out = String::new();
    for Gradient { id, upper, lower } in gradients {
        let _ = write!(
            out,
            "<linearGradient id=\"{id}\" x1=\"0\" y1=\"0\" x2=\"0\" y2=\"1\"><stop offset=\"0\" stop-color=\"{upper}\"/>\
             <stop offset=\"1\" stop-color=\"{lower}\"/></linearGradient>",
        );
    }
    out
}
