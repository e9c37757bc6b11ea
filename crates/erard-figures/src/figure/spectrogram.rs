//! A spectrogram: levels over time and frequency, in shades of grey.

use crate::picture::{Anchor, Geometry, Head, Look, Paint, Picture, Segment, Shape, Words};

/// Shades between nothing and the loudest place.
const SHADES: usize = 24;
/// The picture, px: its size, and where the plot lies in it.
const SIZE: [f64; 2] = [900.0, 460.0];
const PLOT: [f64; 4] = [70.0, 50.0, 800.0, 350.0];

/// Levels of a sound over time and frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrogram {
    /// Headline.
    pub title: String,
    /// A line below it.
    pub subtitle: String,
    /// Columns that share the duration equally, each with as many rows, which share the frequencies; the lowest first.
    /// 0 is white and 1 is black.
    pub levels: Vec<Vec<f64>>,
    /// Duration of the sound, s.
    pub duration_s: f64,
    /// Upper end of the highest row, Hz.
    pub highest_hz: f64,
}

impl Spectrogram {
    /// The spectrogram as a picture.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let [left, top, width, height] = PLOT;
        let white = vec![Look::Fill(Paint::Colour("#fff"))];
        let mut out = vec![
            Shape::with(Geometry::Rect(None, SIZE), white),
            Words::node("", [left, 20.0], [], &self.title),
            Words::node("", [left, 38.0], [], &self.subtitle),
        ];
        for shade in 1..=SHADES {
            let grey = (255 - 255 * shade / SHADES) as u8;
            out.push(Shape::looking(vec![Look::Fill(Paint::Grey(grey))], Geometry::Cells(self.cells(shade))));
        }
        let axes = [[left, top], [left, top + height], [left + width, top + height]];
        let axes = vec![Segment::Move(axes[0]), Segment::Line(axes[1]), Segment::Line(axes[2])];
        out.push(Shape::looking(
            vec![Look::Fill(Paint::None), Look::Stroke(Paint::Colour("#333"))],
            Geometry::Path(axes),
        ));
        for khz in (0..=(self.highest_hz / 1e3) as u32).step_by(2) {
            let y = top + height * (1.0 - f64::from(khz) * 1e3 / self.highest_hz);
            let looks = [Look::Anchor(Anchor::End)];
            out.push(Words::node("", [left - 6.0, y + 4.0], looks, &format!("{khz} kHz")));
        }
        for part in 0..=4 {
            let share = f64::from(part) / 4.0;
            let place = [left + share * width, top + height + 18.0];
            let looks = [Look::Anchor(Anchor::Middle)];
            out.push(Words::node("", place, looks, &format!("{:.2} s", share * self.duration_s)));
        }
        let head = Head {
            title: self.title.clone(),
            size_px: SIZE,
            view: [0.0, 0.0, SIZE[0], SIZE[1]],
            font_size: Some(12),
            style: Vec::new(),
            rule_end: "",
            gradients: &[],
        };
        Picture { head, nodes: out }
    }

    /// The rectangles of a shade: neighbouring rows of a column are one.
    fn cells(&self, shade: usize) -> Vec<[f64; 4]> {
        let [left, top, width, height] = PLOT;
        let wide = width / self.levels.len().max(1) as f64;
        let mut cells = Vec::new();
        for (i, column) in self.levels.iter().enumerate() {
            let tall = height / column.len().max(1) as f64;
            let is_it = |row: usize| (column[row] * SHADES as f64).round() as usize == shade;
            let mut row = 0;
            while row < column.len() {
                let from = row;
                while row < column.len() && is_it(row) {
                    row += 1;
                }
                if row > from {
                    let y = top + height - row as f64 * tall;
                    cells.push([left + i as f64 * wide, y, wide, (row - from) as f64 * tall]);
                }
                row = row.max(from + 1);
            }
        }
        cells
    }
}
