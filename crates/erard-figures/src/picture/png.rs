//! A picture as a PNG.

use tiny_skia::{
    Color, FillRule, GradientStop, LineCap, LineJoin, LinearGradient, Mask, Path, PathBuilder, Pixmap, Point, Rect,
    Shader, SpreadMode, Stroke, StrokeDash, Transform,
};

use super::face::face;
use super::{Anchor, Clip, Geometry, Gradient, Group, Head, Look, Node, Paint, Picture, Segment, Shape, Turn, Words};

/// Largest width and height of a PNG, px.
const MAX_SIDE: f64 = 16_384.0;
/// Height of letters where nothing is said, px.
const LETTERS: f64 = 12.0;

/// Why a picture could not be turned into a PNG.
#[derive(Debug)]
#[non_exhaustive]
pub enum PngError {
    /// The picture would be empty or too large.
    Size {
        /// Width asked for, px.
        width: f64,
        /// Height asked for, px.
        height: f64,
    },
    /// The encoder failed.
    Encode(String),
}

impl std::fmt::Display for PngError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Size { width, height } => {
                write!(f, "a PNG of {width:.0} x {height:.0} px is not possible")
            }
            Self::Encode(why) => write!(f, "the PNG cannot be encoded: {why}"),
        }
    }
}

impl std::error::Error for PngError {}

pub(super) fn png(picture: &Picture, scale: f64) -> Result<Vec<u8>, PngError> {
    let head = &picture.head;
    let [width, height] = head.size_px.map(|side| (side * scale).round());
    let possible = 1.0..=MAX_SIDE;
    if !possible.contains(&width) || !possible.contains(&height) {
        return Err(PngError::Size { width, height });
    }
    let Some(mut pixels) = Pixmap::new(width as u32, height as u32) else {
        return Err(PngError::Size { width, height });
    };
    pixels.fill(Color::WHITE);
    // As large as fits, in the middle: what `viewBox` means.
    let [left, top, wide, tall] = head.view;
    let unit = scale * (head.size_px[0] / wide).min(head.size_px[1] / tall);
    let [x, y] = [0.5 * (width - unit * wide) - unit * left, 0.5 * (height - unit * tall) - unit * top];
    let to_pixels = Transform::from_row(unit as f32, 0.0, 0.0, unit as f32, x as f32, y as f32);
    Painter { pixels: &mut pixels, head }.paint(&picture.nodes, "", to_pixels, None);
    encode(&pixels).map_err(|error| PngError::Encode(error.to_string()))
}

/// By deflate's fastest level: a third larger than by its usual one, and written in a fifth of the time.
fn encode(pixels: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let mut colours = vec![0; pixels.data().len() / 4 * 3];
    for (colour, pixel) in colours.chunks_exact_mut(3).zip(pixels.data().chunks_exact(4)) {
        colour.copy_from_slice(&pixel[..3]);
    }
    let mut data = Vec::new();
    let mut encoder = png::Encoder::new(&mut data, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_deflate_compression(png::DeflateCompression::Level(1));
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&colours)?;
    writer.finish()?;
    Ok(data)
}

/// All properties of a shape or of words.
#[derive(Clone)]
struct Style {
    fill: Paint,
    fill_opacity: f64,
    stroke: Paint,
    width: f64,
    dashes: Option<[f64; 2]>,
    join: LineJoin,
    cap: LineCap,
    stroke_first: bool,
    font_size: f64,
    anchor: Option<Anchor>,
}

impl Style {
    fn take(&mut self, look: &Look) {
        match look {
            Look::Fill(paint) => self.fill = *paint,
            Look::FillOpacity(share) => self.fill_opacity = *share,
            Look::Stroke(paint) => self.stroke = *paint,
            Look::StrokeWidth(width) | Look::StrokeWidthPx(width) => self.width = *width,
            Look::Dashes(dashes) => self.dashes = Some(*dashes),
            Look::RoundJoins => self.join = LineJoin::Round,
            Look::RoundCaps => self.cap = LineCap::Round,
            Look::StrokeFirst => self.stroke_first = true,
            Look::FontSize(size) => self.font_size = *size,
            Look::NormalWeight => {}
            Look::Anchor(anchor) => self.anchor = Some(*anchor),
        }
    }
}

struct Painter<'a> {
    pixels: &'a mut Pixmap,
    head: &'a Head,
}

impl Painter<'_> {
    /// Paints nodes of a group of some class.
    fn paint(&mut self, nodes: &[Node], within: &str, to_pixels: Transform, mask: Option<&Mask>) {
        for node in nodes {
            match node {
                Node::Clip(_) => {}
                Node::Group(Group { class, clip, carried, nodes }) => {
                    let to_pixels = moved(to_pixels, carried.turn);
                    let clipped = clip.as_ref().and_then(|clip| self.mask(clip, to_pixels));
                    self.paint(nodes, class, to_pixels, clipped.as_ref().or(mask));
                }
                Node::Shape(shape) => self.shape(shape, within, to_pixels, mask),
                Node::Words(words) => self.words(words, to_pixels, mask),
            }
        }
    }

    fn mask(&self, Clip { area, .. }: &Clip, to_pixels: Transform) -> Option<Mask> {
        let mut mask = Mask::new(self.pixels.width(), self.pixels.height())?;
        mask.fill_path(&rectangle(*area)?, FillRule::Winding, true, to_pixels);
        Some(mask)
    }

    /// What the classes' rules say wins over what a shape says itself.
    fn style<'a>(&self, within: &str, classes: &str, looks: impl Iterator<Item = &'a Look>) -> Style {
        let mut style = Style {
            fill: Paint::Colour("#000"),
            fill_opacity: 1.0,
            stroke: Paint::None,
            width: 1.0,
            dashes: None,
            join: LineJoin::Miter,
            cap: LineCap::Butt,
            stroke_first: false,
            font_size: self.head.font_size.map_or(LETTERS, f64::from),
            anchor: None,
        };
        looks.for_each(|look| style.take(look));
        let rules = self.head.style.iter().copied().flatten();
        rules
            .filter(|rule| rule.is_about(within, classes))
            .flat_map(|rule| rule.looks)
            .for_each(|look| style.take(look));
        style
    }

    fn shape(&mut self, shape: &Shape, within: &str, to_pixels: Transform, mask: Option<&Mask>) {
        let style = self.style(within, &shape.class, shape.before.iter().chain(&shape.after));
        if let Some(path) = path(&shape.geometry) {
            self.draw(&path, &style, moved(to_pixels, shape.carried.turn), mask);
        }
    }

    fn words(&mut self, words: &Words, to_pixels: Transform, mask: Option<&Mask>) {
        let style = self.style("", &words.class, words.looks.iter());
        // SVG, too, has no more than one space between words.
        let text = words.text.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
        let size = style.font_size as f32;
        let left = match style.anchor {
            None => 0.0,
            Some(Anchor::Middle) => -0.5 * face().width(&text, size),
            Some(Anchor::End) => -face().width(&text, size),
        };
        let mut outlines = PathBuilder::new();
        face().draw(&text, size, [left, 0.0], &mut outlines);
        if let Some(path) = outlines.finish() {
            let turn = Turn { to: words.at, degrees: if words.upwards { -90.0 } else { 0.0 } };
            self.draw(&path, &style, moved(to_pixels, Some(turn)), mask);
        }
    }

    fn draw(&mut self, path: &Path, style: &Style, to_pixels: Transform, mask: Option<&Mask>) {
        if style.stroke_first {
            self.stroke(path, style, to_pixels, mask);
        }
        if let Some(shader) = self.shader(style.fill, style.fill_opacity, path) {
            let paint = tiny_skia::Paint { shader, anti_alias: true, ..tiny_skia::Paint::default() };
            self.pixels.fill_path(path, &paint, FillRule::Winding, to_pixels, mask);
        }
        if !style.stroke_first {
            self.stroke(path, style, to_pixels, mask);
        }
    }

    fn stroke(&mut self, path: &Path, style: &Style, to_pixels: Transform, mask: Option<&Mask>) {
        let Some(shader) = self.shader(style.stroke, 1.0, path) else { return };
        let paint = tiny_skia::Paint { shader, anti_alias: true, ..tiny_skia::Paint::default() };
        let stroke = Stroke {
            width: style.width as f32,
            line_cap: style.cap,
            line_join: style.join,
            dash: style.dashes.and_then(|dashes| StrokeDash::new(dashes.map(|dash| dash as f32).to_vec(), 0.0)),
            ..Stroke::default()
        };
        self.pixels.stroke_path(path, &paint, &stroke, to_pixels, mask);
    }

    /// `None` where nothing is painted.
    fn shader(&self, paint: Paint, opacity: f64, path: &Path) -> Option<Shader<'static>> {
        match paint {
            Paint::None => None,
            Paint::Colour(text) => Some(solid(colour(text), opacity)),
            Paint::Grey(grey) => Some(solid(Color::from_rgba8(grey, grey, grey, 255), opacity)),
            Paint::Gradient(id) => {
                let Gradient { upper, lower, .. } = self.head.gradients.iter().find(|gradient| gradient.id == id)?;
                let bounds = path.compute_tight_bounds()?;
                let [from, to] = [bounds.top(), bounds.bottom()].map(|y| Point::from_xy(0.0, y));
                let stops = vec![GradientStop::new(0.0, colour(upper)), GradientStop::new(1.0, colour(lower))];
                LinearGradient::new(from, to, stops, SpreadMode::Pad, Transform::identity())
            }
        }
    }
}

fn moved(to_pixels: Transform, turn: Option<Turn>) -> Transform {
    let Some(Turn { to, degrees }) = turn else { return to_pixels };
    let [x, y] = point(to);
    to_pixels.pre_translate(x, y).pre_concat(Transform::from_rotate(if degrees.is_finite() {
        degrees as f32
    } else {
        0.0
    }))
}

fn solid(mut colour: Color, opacity: f64) -> Shader<'static> {
    colour.apply_opacity(opacity as f32);
    Shader::SolidColor(colour)
}

/// A colour `#rgb` or `#rrggbb`; black for what is none.
fn colour(text: &str) -> Color {
    let digits = text.trim_start_matches('#');
    let value = u32::from_str_radix(digits, 16).unwrap_or(0);
    let [_, red, green, blue] = match digits.len() {
        3 => [0, (value >> 8) & 0xf, (value >> 4) & 0xf, value & 0xf].map(|digit| (17 * digit) as u8),
        _ => value.to_be_bytes(),
    };
    Color::from_rgba8(red, green, blue, 255)
}

/// As in the SVG: what is not finite is 0.
fn point(point: [f64; 2]) -> [f32; 2] {
    point.map(|c| if c.is_finite() { c as f32 } else { 0.0 })
}

/// `None` where nothing can be drawn.
fn path(geometry: &Geometry) -> Option<Path> {
    let mut out = PathBuilder::new();
    match geometry {
        Geometry::Line(ends) => joined(&mut out, ends),
        Geometry::Rect(corner, [width, height]) => {
            let [left, top] = corner.unwrap_or([0.0; 2]);
            return rectangle([left, top, *width, *height]);
        }
        Geometry::Circle(center, radius) => {
            let [x, y] = point(center.unwrap_or([0.0; 2]));
            out.push_circle(x, y, *radius as f32);
        }
        Geometry::Polyline(points) => joined(&mut out, points),
        Geometry::Polygon(points) => {
            joined(&mut out, points);
            out.close();
        }
        Geometry::Path(segments) => segments.iter().for_each(|one| segment(&mut out, one)),
        Geometry::Cells(cells) => {
            cells.iter().filter_map(|cell| rect(*cell)).for_each(|cell| out.push_rect(cell));
        }
    }
    out.finish()
}

fn joined(out: &mut PathBuilder, points: &[[f64; 2]]) {
    for (index, [x, y]) in points.iter().map(|at| point(*at)).enumerate() {
        if index == 0 { out.move_to(x, y) } else { out.line_to(x, y) }
    }
}

fn segment(out: &mut PathBuilder, segment: &Segment) {
    match segment {
        Segment::Move(to) => {
            let [x, y] = point(*to);
            out.move_to(x, y);
        }
        Segment::Line(to) => {
            let [x, y] = point(*to);
            out.line_to(x, y);
        }
        Segment::Vertical(y) => {
            let x = out.last_point().map_or(0.0, |last| last.x);
            out.line_to(x, point([*y, 0.0])[0]);
        }
        Segment::Quad(control, to) => {
            let ([cx, cy], [x, y]) = (point(*control), point(*to));
            out.quad_to(cx, cy, x, y);
        }
        Segment::Close => out.close(),
    }
}

fn rect([left, top, width, height]: [f64; 4]) -> Option<Rect> {
    let ([left, top], [width, height]) = (point([left, top]), point([width, height]));
    Rect::from_xywh(left, top, width, height)
}

fn rectangle(sides: [f64; 4]) -> Option<Path> {
    rect(sides).filter(|rect| rect.width() > 0.0 && rect.height() > 0.0).map(PathBuilder::from_rect)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Rule;

    /// Words on a small sheet.
    fn sheet(text: &str) -> Picture {
        let head = Head {
            title: String::new(),
            size_px: [120.0, 40.0],
            view: [0.0, 0.0, 120.0, 40.0],
            font_size: Some(20),
            style: Vec::new(),
            rule_end: "",
            gradients: &[],
        };
        Picture { head, nodes: vec![Words::node("", [4.0, 28.0], [], text)] }
    }

    fn dark_pixels(png: &[u8]) -> usize {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        pixels.chunks_exact(3).filter(|pixel| pixel[0] < 100).count()
    }

    /// The classic failure is a PNG whose text is simply not there.
    #[test]
    fn text_is_in_the_png() {
        assert_eq!(dark_pixels(&sheet("").png(2.0).unwrap()), 0);
        let all = "let-off µ²";
        let with = dark_pixels(&sheet(all).png(2.0).unwrap());
        assert!(with > 300, "{with} dark pixels");
        // Each letter counts.
        for letter in all.chars() {
            let less: String = all.chars().filter(|other| *other != letter).collect();
            assert!(letter == '-' || dark_pixels(&sheet(&less).png(2.0).unwrap()) < with, "{letter}");
        }
    }

    #[test]
    fn the_same_picture_gives_the_same_png() {
        assert_eq!(sheet("hammer").png(1.0).unwrap(), sheet("hammer").png(1.0).unwrap());
    }

    #[test]
    fn what_cannot_be_painted_says_so() {
        assert!(matches!(sheet("x").png(1e6), Err(PngError::Size { .. })));
        assert!(matches!(sheet("x").png(f64::NAN), Err(PngError::Size { .. })));
    }

    #[test]
    fn colours_are_read() {
        assert_eq!(colour("#f0a"), Color::from_rgba8(255, 0, 170, 255));
        assert_eq!(colour("#12ab9f"), Color::from_rgba8(0x12, 0xab, 0x9f, 255));
    }

    /// Both writers look for a rule in the same sheet: the SVG's text has it, and the PNG's pixels are of its colour.
    #[test]
    fn both_writers_read_one_sheet() {
        const RULES: &[Rule] = &[Rule::new(&["a", "b"], &[Look::Fill(Paint::Colour("#00f"))])];
        let mut picture = sheet("");
        picture.head.style.push(RULES);
        picture.nodes = vec![Shape::of_class("a b", Geometry::Rect(None, [120.0, 40.0]))];
        assert!(picture.svg().contains("<style>.a.b{fill:#00f}</style>"));
        let blue = |picture: &Picture| {
            let data = picture.png(1.0).unwrap();
            let mut reader = png::Decoder::new(std::io::Cursor::new(data)).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            pixels[..3] == [0, 0, 255]
        };
        assert!(blue(&picture));
        picture.nodes = vec![Shape::of_class("a", Geometry::Rect(None, [120.0, 40.0]))];
        assert!(!blue(&picture));
    }
}
