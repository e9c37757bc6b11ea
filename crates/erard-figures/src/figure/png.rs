//! SVG to PNG, with a font of our own.

use resvg::{tiny_skia, usvg};
use std::sync::{Arc, OnceLock};

/// DejaVu Sans, unchanged (licence beside it). Bundled, because a rasteriser without the font asked for leaves text
/// out without a word, and because the same picture should come out on every machine.
static FONT: &[u8] = include_bytes!("../../assets/DejaVuSans.ttf");

/// Largest width and height of a PNG, px.
const LARGEST_SIDE: f64 = 16_384.0;

/// Why a picture could not be turned into a PNG.
#[derive(Debug)]
pub enum PngError {
    /// The SVG is not well-formed or holds nothing to draw.
    Svg(String),
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
            Self::Svg(why) => write!(f, "the SVG cannot be read: {why}"),
            Self::Size { width, height } => {
                write!(f, "a PNG of {width:.0} x {height:.0} px is not possible")
            }
            Self::Encode(why) => write!(f, "the PNG cannot be encoded: {why}"),
        }
    }
}

impl std::error::Error for PngError {}

fn fonts() -> Arc<usvg::fontdb::Database> {
    static FONTS: OnceLock<Arc<usvg::fontdb::Database>> = OnceLock::new();
    FONTS
        .get_or_init(|| {
            let mut fonts = usvg::fontdb::Database::new();
            fonts.load_font_source(usvg::fontdb::Source::Binary(Arc::new(FONT)));
            // whatever family a document names, it gets the one font there is
            fonts.set_sans_serif_family("DejaVu Sans");
            fonts.set_serif_family("DejaVu Sans");
            fonts.set_monospace_family("DejaVu Sans");
            Arc::new(fonts)
        })
        .clone()
}

/// Renders an SVG document on white, at `scale` pixels per SVG pixel. The same document gives the same bytes.
pub fn png_from_svg(svg: &str, scale: f64) -> Result<Vec<u8>, PngError> {
    let options = usvg::Options { fontdb: fonts(), font_family: "DejaVu Sans".to_owned(), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(svg, &options).map_err(|error| PngError::Svg(error.to_string()))?;
    let width = (f64::from(tree.size().width()) * scale).round();
    let height = (f64::from(tree.size().height()) * scale).round();
    let possible = 1.0..=LARGEST_SIDE;
    if !possible.contains(&width) || !possible.contains(&height) {
        return Err(PngError::Size { width, height });
    }
    let Some(mut pixels) = tiny_skia::Pixmap::new(width as u32, height as u32) else {
        return Err(PngError::Size { width, height });
    };
    pixels.fill(tiny_skia::Color::WHITE);
    let transform = tiny_skia::Transform::from_scale(scale as f32, scale as f32);
    resvg::render(&tree, transform, &mut pixels.as_mut());
    encode(&pixels).map_err(|error| PngError::Encode(error.to_string()))
}

/// By deflate's fastest level: a third larger than by its usual one, and written in a fifth of the time.
fn encode(pixels: &tiny_skia::Pixmap) -> Result<Vec<u8>, png::EncodingError> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn svg(text: &str, family: &str) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"120\" height=\"40\"><rect width=\"120\" height=\"40\" \
             fill=\"white\"/><text x=\"4\" y=\"28\" font-size=\"20\" font-family=\"{family}\">{text}</text></svg>"
        )
    }

    fn dark_pixels(png: &[u8]) -> usize {
        let pixels = tiny_skia::Pixmap::decode_png(png).unwrap();
        pixels.pixels().iter().filter(|pixel| pixel.red() < 100).count()
    }

    /// The classic failure is a PNG whose text is simply not there.
    #[test]
    fn text_is_in_the_png() {
        let without = dark_pixels(&png_from_svg(&svg("", "sans-serif"), 2.0).unwrap());
        assert_eq!(without, 0);
        for family in [crate::drawing::FONTS, "sans-serif", "A Font Nobody Has", ""] {
            let with = dark_pixels(&png_from_svg(&svg("let-off µ²", family), 2.0).unwrap());
            assert!(with > 300, "{family}: {with} dark pixels");
        }
    }

    #[test]
    fn the_same_svg_gives_the_same_png() {
        let svg = svg("hammer", "sans-serif");
        assert_eq!(png_from_svg(&svg, 1.0).unwrap(), png_from_svg(&svg, 1.0).unwrap());
    }

    #[test]
    fn what_cannot_be_rendered_says_so() {
        assert!(matches!(png_from_svg("no svg", 1.0), Err(PngError::Svg(_))));
        assert!(matches!(png_from_svg(&svg("x", "y"), 1e6), Err(PngError::Size { .. })));
        assert!(matches!(png_from_svg(&svg("x", "y"), f64::NAN), Err(PngError::Size { .. })));
    }
}
