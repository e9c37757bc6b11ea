//! The one face that pictures are lettered in: outlines, widths and kerning of DejaVu Sans.
//!
//! `truetype` reads the tables. Letters are set from left to right, one glyph for each character, with the face's
//! kerning and its ligatures of `f`: all that Latin, Greek and Cyrillic need. Before, a text is brought into that form:
//! accents composed, Arabic letters joined, what runs to the left reversed. Marks without a composed letter stand
//! behind their letter; scripts that need more, and characters that the face lacks, need a browser and the SVG.

use std::borrow::Cow;
use std::io::{Cursor, Seek, SeekFrom};
use std::sync::OnceLock;

use tiny_skia::PathBuilder;
use truetype::tables::character_mapping::{Encoding12, Header, Record, SequentialGroup};
use truetype::tables::glyph_data::{Arguments, Description, Glyph, SimpleDescription};
use truetype::tables::{FontHeader, GlyphMapping, HorizontalHeader, HorizontalMetrics, MaximumProfile, Offsets};
use truetype::tape::Read;
use truetype::{GlyphID, Result};
use unicode_bidi::BidiInfo;
use unicode_normalization::UnicodeNormalization;

/// DejaVu Sans, unchanged (licence beside it). Bundled, so that the same picture comes out on every machine.
static FONT: &[u8] = include_bytes!("../../assets/DejaVuSans.ttf");

/// Letters that are drawn as one where they follow each other; the longest first.
const LIGATURES: [(&str, char); 5] =
    [("ffi", '\u{fb03}'), ("ffl", '\u{fb04}'), ("ff", '\u{fb00}'), ("fi", '\u{fb01}'), ("fl", '\u{fb02}')];

/// A point of a contour, in units of the face, and whether it is on the curve.
type Knot = ([i32; 2], bool);

/// The tables of the face that are asked for every glyph.
pub(super) struct Face {
    units_per_em: f32,
    characters: Vec<SequentialGroup>,
    widths: HorizontalMetrics,
    /// Where each glyph's outline begins in the file, and where the last one ends.
    outlines: Vec<u64>,
    /// Pairs of glyphs, left and right, with what they stand closer or wider; ascending.
    kerning: Vec<([GlyphID; 2], i16)>,
}

/// The face.
pub(super) fn face() -> &'static Face {
    static FACE: OnceLock<Face> = OnceLock::new();
    FACE.get_or_init(|| Face::read().expect("the font is built in"))
}

impl Face {
    fn read() -> Result<Self> {
        let mut tape = Cursor::new(FONT);
        let tables: Offsets = tape.take()?;
        let at =
            |tag: &[u8; 4]| tables.iter().find(|table| table.tag.0 == *tag).map_or(0, |table| u64::from(table.offset));
        let seek = |tape: &mut Cursor<&[u8]>, place: u64| tape.seek(SeekFrom::Start(place));
        seek(&mut tape, at(b"head"))?;
        let header: FontHeader = tape.take()?;
        seek(&mut tape, at(b"maxp"))?;
        let profile: MaximumProfile = tape.take()?;
        seek(&mut tape, at(b"hhea"))?;
        let horizontal: HorizontalHeader = tape.take()?;
        seek(&mut tape, at(b"hmtx"))?;
        let widths = tape.take_given((&horizontal, &profile))?;
        seek(&mut tape, at(b"loca"))?;
        let places: GlyphMapping = tape.take_given((&header, &profile))?;
        let outlines = match places {
            GlyphMapping::HalfOffsets(halves) => halves.iter().map(|half| 2 * u64::from(*half)).collect::<Vec<_>>(),
            GlyphMapping::Offsets(offsets) => offsets.iter().map(|offset| u64::from(*offset)).collect(),
        };
        seek(&mut tape, at(b"cmap"))?;
        let encodings: Header = tape.take()?;
        let encodings = (0..encodings.table_count).map(|_| tape.take()).collect::<Result<Vec<Record>>>()?;
        // All of Unicode: platform 3, encoding 10 is always in format 12.
        let unicode = encodings.iter().find(|one| (one.platform_id, one.encoding_id) == (3, 10));
        seek(&mut tape, at(b"cmap") + unicode.map_or(0, |one| u64::from(one.offset)))?;
        let characters = tape.take::<Encoding12>()?.groups;
        // One subtable, in format 0, behind the heads of the table and of the subtable.
        seek(&mut tape, at(b"kern") + 4 + 6)?;
        let pairs: u16 = tape.take()?;
        seek(&mut tape, at(b"kern") + 4 + 14)?;
        let pair = |_| Ok(([tape.take()?, tape.take()?], tape.take()?));
        let kerning = (0..pairs).map(pair).collect::<Result<Vec<_>>>()?;
        let outlines = outlines.into_iter().map(|offset| at(b"glyf") + offset).collect();
        Ok(Face { units_per_em: f32::from(header.units_per_em), characters, widths, outlines, kerning })
    }

    /// The glyph of a character; 0, an empty box, for one that the face lacks.
    fn glyph(&self, character: char) -> GlyphID {
        let code = u32::from(character);
        let group = self.characters.partition_point(|group| group.end_code < code);
        match self.characters.get(group) {
            Some(group) if group.start_code <= code => (group.start_glyph_id + code - group.start_code) as GlyphID,
            _ => 0,
        }
    }

    /// Glyphs of a text and where each begins, in units of the face, and the text's width.
    fn set(&self, text: &str) -> (Vec<(GlyphID, i32)>, i32) {
        let mut glyphs: Vec<(GlyphID, i32)> = Vec::new();
        let text = visual(text);
        let (mut pen, mut rest) = (0, &*text);
        while let Some(first) = rest.chars().next() {
            let ligature = LIGATURES.iter().find(|(letters, _)| rest.starts_with(letters));
            let (character, length) =
                ligature.map_or((first, first.len_utf8()), |(letters, one)| (*one, letters.len()));
            rest = &rest[length..];
            let glyph = self.glyph(character);
            if let Some((before, _)) = glyphs.last() {
                let pair = self.kerning.binary_search_by_key(&[*before, glyph], |(pair, _)| *pair);
                pen += pair.map_or(0, |place| i32::from(self.kerning[place].1));
            }
            glyphs.push((glyph, pen));
            pen += i32::from(self.widths.get(glyph).0);
        }
        (glyphs, pen)
    }

    /// Width of a text in letters of some size.
    pub(super) fn width(&self, text: &str, size: f32) -> f32 {
        self.set(text).1 as f32 * size / self.units_per_em
    }

    /// Adds the outlines of a text, its base line beginning at a place.
    pub(super) fn draw(&self, text: &str, size: f32, [x, y]: [f32; 2], path: &mut PathBuilder) {
        let scale = size / self.units_per_em;
        for (glyph, pen) in self.set(text).0 {
            let to = |[dx, dy]: [i32; 2]| (x + scale * (pen + dx) as f32, y - scale * dy as f32);
            self.outline(glyph, [0, 0], &mut |contour| draw(contour, &to, path));
        }
    }

    /// The contours of a glyph moved by so much.
    fn outline(&self, glyph: GlyphID, [x, y]: [i32; 2], contour: &mut dyn FnMut(&[Knot])) {
        let glyph = usize::from(glyph);
        let (Some(from), Some(to)) = (self.outlines.get(glyph), self.outlines.get(glyph + 1)) else { return };
        let mut tape = Cursor::new(FONT);
        tape.set_position(*from);
        let read = if from < to { tape.take::<Glyph>() } else { return };
        match read.expect("the font is built in").description {
            Description::Simple(simple) => contours(&simple, [x, y]).iter().for_each(|one| contour(one)),
            Description::Composite(composite) => {
                for part in composite.components {
                    // No glyph of this face scales its parts or joins them at points.
                    let Arguments::Offsets(dx, dy) = part.arguments else { continue };
                    self.outline(part.glyph_id, [x + i32::from(dx), y + i32::from(dy)], contour);
                }
            }
        }
    }
}

/// The characters of a line in the order in which they are drawn from left to right, with composed accents, and in the
/// forms in which Arabic letters join.
fn visual(text: &str) -> Cow<'_, str> {
    if text.is_ascii() {
        return Cow::Borrowed(text);
    }
    let joined = ar_reshaper::reshape_line(text.nfc().collect::<String>());
    let order = BidiInfo::new(&joined, None);
    Cow::Owned(order.paragraphs.iter().map(|line| order.reorder_line(line, line.range.clone())).collect())
}

/// The contours of a simple glyph, whose points are each relative to the one before.
fn contours(simple: &SimpleDescription, [mut x, mut y]: [i32; 2]) -> Vec<Vec<Knot>> {
    let mut points = Vec::with_capacity(simple.flags.len());
    for ((flags, dx), dy) in simple.flags.iter().zip(&simple.x).zip(&simple.y) {
        (x, y) = (x + i32::from(*dx), y + i32::from(*dy));
        points.push(([x, y], flags.is_on_curve()));
    }
    let mut from = 0;
    let contour = |end: &u16| {
        let to = usize::from(*end) + 1;
        let contour = points[from..to].to_vec();
        from = to;
        contour
    };
    simple.end_points.iter().map(contour).collect()
}

/// Adds a closed contour of quadratic curves: between two control points that follow each other lies a point of the
/// curve, half-way.
fn draw(contour: &[Knot], to: &dyn Fn([i32; 2]) -> (f32, f32), path: &mut PathBuilder) {
    let half = |a: (f32, f32), b: (f32, f32)| (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1));
    let ([first, ..], [.., last]) = (contour, contour) else { return };
    let on = contour.iter().position(|(_, is_on)| *is_on);
    let (start, begin) = match on {
        Some(on) => (to(contour[on].0), on + 1),
        None => (half(to(last.0), to(first.0)), 0),
    };
    path.move_to(start.0, start.1);
    let mut control: Option<(f32, f32)> = None;
    let mut curve = |control: &mut Option<(f32, f32)>, end: (f32, f32)| match control.take() {
        Some(by) => path.quad_to(by.0, by.1, end.0, end.1),
        None => path.line_to(end.0, end.1),
    };
    for (point, is_on) in contour.iter().cycle().skip(begin).take(contour.len() - usize::from(on.is_some())) {
        let point = to(*point);
        if *is_on {
            curve(&mut control, point);
        } else {
            if let Some(before) = control {
                curve(&mut control, half(before, point));
            }
            control = Some(point);
        }
    }
    curve(&mut control, start);
    path.close();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every glyph of the face can be read and drawn, and none is built in a way that is not drawn: of parts that are
    /// scaled or joined at points.
    #[test]
    fn all_glyphs_are_drawn() {
        use truetype::tables::glyph_data::Options;
        let face = face();
        let mut composites = 0;
        for (glyph, ends) in face.outlines.windows(2).enumerate().filter(|(_, ends)| ends[0] < ends[1]) {
            let mut tape = Cursor::new(FONT);
            tape.set_position(ends[0]);
            if let Description::Composite(composite) = tape.take::<Glyph>().unwrap().description {
                composites += 1;
                for part in &composite.components {
                    assert!(matches!(part.arguments, Arguments::Offsets(..)), "{glyph}");
                    assert!(matches!(part.options, Options::None), "{glyph}");
                }
            }
            let mut path = PathBuilder::new();
            face.outline(glyph as GlyphID, [0, 0], &mut |contour| {
                draw(contour, &|[x, y]| (x as f32, y as f32), &mut path)
            });
            assert!(!path.is_empty(), "{glyph}");
        }
        assert!(face.outlines.len() == 6254 && composites == 2607);
    }

    /// What is set, glyph by glyph, as HarfBuzz's rules set it: `rustybuzz` 0.20 gave these numbers, HarfBuzz itself
    /// those of composed accents, Hebrew and Arabic.
    #[test]
    fn text_is_set_as_a_shaper_sets_it() {
        for (text, expected) in [
            (
                "Stoßzunge Ärger öde µ² °C → − ± × ½ ³ ‰",
                vec![
                    (54, 0),
                    (87, 1300),
                    (82, 2103),
                    (161, 3356),
                    (93, 4646),
                    (88, 5721),
                    (81, 7019),
                    (74, 8317),
                    (72, 9617),
                    (3, 10877),
                    (134, 11528),
                    (85, 12929),
                    (74, 13735),
                    (72, 15035),
                    (85, 16295),
                    (3, 17137),
                    (184, 17788),
                    (71, 19041),
                    (72, 20341),
                    (3, 21601),
                    (119, 22252),
                    (116, 23555),
                    (3, 24376),
                    (114, 25027),
                    (38, 26051),
                    (3, 27481),
                    (3101, 28132),
                    (3, 29848),
                    (3229, 30499),
                    (3, 32215),
                    (115, 32866),
                    (3, 34582),
                    (153, 35233),
                    (3, 36949),
                    (127, 37600),
                    (3, 39585),
                    (117, 40236),
                    (3, 41057),
                    (2835, 41708),
                ],
            ),
            (
                "first fluffy officer affluent ffi ffl fl fi",
                vec![
                    (5042, 0),
                    (85, 1290),
                    (86, 2132),
                    (87, 3199),
                    (3, 4002),
                    (5043, 4653),
                    (88, 5943),
                    (5041, 7241),
                    (92, 8652),
                    (3, 9864),
                    (82, 10515),
                    (5044, 11768),
                    (70, 13748),
                    (72, 14874),
                    (85, 16134),
                    (3, 16976),
                    (68, 17627),
                    (5045, 18882),
                    (88, 20862),
                    (72, 22160),
                    (81, 23420),
                    (87, 24718),
                    (3, 25521),
                    (5044, 26172),
                    (3, 28152),
                    (5045, 28803),
                    (3, 30783),
                    (5043, 31434),
                    (3, 32724),
                    (5042, 33375),
                ],
            ),
            (
                "AVATAR Te To Ty Yo LT P. W, V. We",
                vec![
                    (36, 0),
                    (57, 1270),
                    (36, 2540),
                    (55, 3782),
                    (36, 4874),
                    (53, 6275),
                    (3, 7698),
                    (55, 8349),
                    (72, 9252),
                    (3, 10512),
                    (55, 11163),
                    (82, 12066),
                    (3, 13319),
                    (55, 13970),
                    (92, 14902),
                    (3, 16114),
                    (60, 16765),
                    (82, 17744),
                    (3, 18997),
                    (47, 19648),
                    (55, 20507),
                    (3, 21758),
                    (51, 22409),
                    (17, 23325),
                    (3, 23976),
                    (58, 24627),
                    (15, 26652),
                    (3, 27303),
                    (57, 27954),
                    (17, 29091),
                    (3, 29742),
                    (58, 30393),
                    (72, 32298),
                ],
            ),
            (
                "10⁻³ m·s⁻¹ ≤ ≥ ≈ ∞ √",
                vec![
                    (20, 0),
                    (19, 1303),
                    (2903, 2606),
                    (117, 3687),
                    (3, 4508),
                    (80, 5159),
                    (121, 7154),
                    (86, 7805),
                    (2903, 8872),
                    (123, 9953),
                    (3, 10774),
                    (3311, 11425),
                    (3, 13141),
                    (3312, 13792),
                    (3, 15508),
                    (3283, 16159),
                    (3, 17875),
                    (3241, 18526),
                    (3, 20232),
                    (3237, 20883),
                ],
            ),
            (
                "Ёлка тест",
                vec![
                    (918, 0),
                    (976, 1294),
                    (975, 2603),
                    (965, 3840),
                    (3, 5095),
                    (983, 5746),
                    (970, 6939),
                    (982, 8199),
                    (983, 9325),
                ],
            ),
            (
                "e\u{301}tude Stu\u{308}ck",
                vec![
                    (171, 0),
                    (87, 1260),
                    (88, 2063),
                    (71, 3361),
                    (72, 4661),
                    (3, 5921),
                    (54, 6572),
                    (87, 7872),
                    (190, 8675),
                    (70, 9973),
                    (78, 11099),
                ],
            ),
            ("פסנתר", vec![(1343, 0), (1345, 1156), (1335, 2502), (1336, 3322), (1339, 4651)]),
            ("אבג 88", vec![(27, 0), (27, 1303), (3, 2606), (1321, 3257), (1320, 4101), (1319, 5285)]),
            ("بيانو", vec![(5352, 0), (5345, 1058), (5256, 1628), (5358, 2252), (5259, 2870)]),
        ] {
            assert_eq!(face().set(text).0, expected, "{text}");
        }
        // What the face lacks is a box, so that one sees that something is missing.
        assert_eq!(face().set("漢").0, [(0, 0)]);
    }
}
