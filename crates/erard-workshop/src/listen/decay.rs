//! One straight line or two through a falling level.

use std::fmt;

/// Below the largest level, dB, from which on nothing is fitted. What a lossy coder leaves ends near there.
const DEPTH_DB: f64 = 45.0;
/// Most points of a fit.
const MAX_POINTS: usize = 400;
/// Fewest points of a fit.
const MIN_POINTS: usize = 12;
/// Share of the fitted time in which points count equally; later ones count as often as the time's logarithm grows.
const EQUAL_SHARE: f64 = 0.05;
/// Windows that the early line lasts at least.
const EARLY_WINDOWS: f64 = 2.0;
/// Share of the fitted time that the late line lasts at least.
const LATE_SHARE: f64 = 0.15;
/// Two stages: the late line is flatter by this factor,
const FLATTER: f64 = 2.0;
/// it begins above this level, dB below the first one,
const BREAK_DB: f64 = -40.0;
/// and the residual is smaller by this factor.
const GAIN: f64 = 2.0;
/// Residual of one line, dB rms, from which a level that does not fall in two stages beats.
const BEATS_DB: f64 = 1.5;
/// A level that stays below the noise for this share of the time passed has ended; beats come back sooner.
const PATIENCE: f64 = 0.15;

/// A level at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    pub time_s: f64,
    pub level_db: f64,
}

/// How a level falls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Fast, then slowly: of two straight lines that meet, the late one is flatter by a factor of 2 or more and falls,
    /// the break is less than 40 dB below the beginning, and the residual is half of one line's or less.
    TwoStages,
    /// In one straight line, within 1.5 dB rms.
    OneLine,
    /// Neither: it rises and falls around its trend.
    Beats,
}

impl Shape {
    /// Name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Shape::TwoStages => "two stages",
            Shape::OneLine => "one line",
            Shape::Beats => "beats",
        }
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Straight lines through a falling level, by least squares over the logarithm of time: one, and two that meet. Fitted
/// from its largest value until it is 45 dB lower, sinks into the noise, or the sound ends. Rates are positive where
/// the level falls.
///
/// Beats that are slower than the fall that is heard (their period longer than two thirds of it) may look like two
/// stages: no fit of lines tells them apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decay {
    /// Verdict.
    pub shape: Shape,
    /// Rate of the early one of two lines, dB/s.
    pub early_db_per_s: f64,
    /// Rate of the late one, dB/s.
    pub late_db_per_s: f64,
    /// Time until the lines meet, s: a partial's from the note's beginning, the level's from its loudest window.
    pub break_s: f64,
    /// Level where they meet, dB above that of the early line at the beginning: negative.
    pub break_db: f64,
    /// Rate of one line, dB/s.
    pub one_line_db_per_s: f64,
    /// Residual of one line over that of two.
    pub gain: f64,
    /// Residual of one line, dB rms.
    pub residual_db: f64,
    /// Effective length of the windows, s.
    pub window_s: f64,
}

impl Decay {
    /// Rate at which the sound begins to fall, dB/s: the early line's of two stages, else that of one line.
    #[must_use]
    pub fn first_db_per_s(&self) -> f64 {
        if self.shape == Shape::TwoStages { self.early_db_per_s } else { self.one_line_db_per_s }
    }
}

/// Fits levels of windows of this effective length, s, counted in time from the note's beginning, from their largest
/// value within the first tenth of `fall_s` or of all times. `floor_db` is the level at a time below which there is
/// noise only. `None` where too little is left.
pub(super) fn decay(
    points: &[Point],
    window_s: f64,
    fall_s: Option<f64>,
    floor_db: &dyn Fn(f64) -> f64,
) -> Option<Decay> {
    let last_s = points.last()?.time_s;
    let within_s = points[0].time_s + 0.1 * fall_s.unwrap_or(last_s - points[0].time_s) + window_s;
    let early = points.iter().take_while(|point| point.time_s <= within_s);
    let top = early.enumerate().max_by(|a, b| a.1.level_db.total_cmp(&b.1.level_db))?.0;
    let points = audible(&points[top..], window_s, floor_db);
    if points.len() < MIN_POINTS {
        return None;
    }
    let thin = points.len().div_ceil(MAX_POINTS);
    let points: Vec<Point> = points.iter().step_by(thin).copied().collect();
    let first_s = points[0].time_s;
    let span_s = points.last()?.time_s - first_s;
    // A second at the beginning says as much of the early line as ten later ones of the late one.
    let weights: Vec<f64> = points.iter().map(|point| 1.0 / (point.time_s - first_s + EQUAL_SHARE * span_s)).collect();
    let total: f64 = weights.iter().sum();
    let one = Line::fit(&points, &weights, None)?;
    let breaks = points.iter().map(|point| point.time_s).filter(|time_s| {
        let early_s = time_s - first_s;
        early_s >= EARLY_WINDOWS * window_s && span_s - early_s >= LATE_SHARE * span_s
    });
    let two = breaks.filter_map(|break_s| Line::fit(&points, &weights, Some(break_s)));
    let two = two.min_by(|a, b| a.squares.total_cmp(&b.squares))?;
    let rms = |line: &Line| (line.squares / total).sqrt();
    let (break_s, late) = (two.break_s, two.slope + two.bend);
    let gain = rms(&one) / rms(&two).max(1e-9);
    let break_db = two.slope * break_s;
    let (early_db_per_s, late_db_per_s) = (-two.slope, -late);
    let is_two =
        late_db_per_s > 0.0 && late_db_per_s * FLATTER <= early_db_per_s && break_db > BREAK_DB && gain >= GAIN;
    let shape = match () {
        () if is_two => Shape::TwoStages,
        () if rms(&one) > BEATS_DB => Shape::Beats,
        () => Shape::OneLine,
    };
    Some(Decay {
        shape,
        early_db_per_s,
        late_db_per_s,
        break_s,
        break_db,
        one_line_db_per_s: -one.slope,
        gain,
        residual_db: rms(&one),
        window_s,
    })
}

/// The points before the level has fallen by [`DEPTH_DB`] or below the noise for good: for longer than beats do.
fn audible<'a>(points: &'a [Point], window_s: f64, floor_db: &dyn Fn(f64) -> f64) -> &'a [Point] {
    let Some(first) = points.first() else { return points };
    let mut heard = 0;
    for (n, point) in points.iter().enumerate() {
        let is_heard = point.level_db > (first.level_db - DEPTH_DB).max(floor_db(point.time_s));
        if is_heard {
            heard = n + 1;
            continue;
        }
        let since_s = points[heard.max(1) - 1].time_s - first.time_s;
        if point.time_s - first.time_s - since_s > (PATIENCE * since_s).max(4.0 * window_s) {
            break;
        }
    }
    &points[..heard]
}

/// A line that bends at an instant: level = at + slope (t - t0) + bend max(0, t - break).
struct Line {
    slope: f64,
    bend: f64,
    break_s: f64,
    /// Weighted sum of squared residuals.
    squares: f64,
}

impl Line {
    /// By the normal equations of two or three functions, centred so that they are well-conditioned.
    fn fit(points: &[Point], weights: &[f64], break_s: Option<f64>) -> Option<Self> {
        let total: f64 = weights.iter().sum();
        let at = break_s.unwrap_or(f64::INFINITY);
        let functions = |point: &Point| [point.time_s, (point.time_s - at).max(0.0), point.level_db];
        let mut mean = [0.0; 3];
        for (point, weight) in points.iter().zip(weights) {
            mean.iter_mut().zip(functions(point)).for_each(|(mean, x)| *mean += weight * x / total);
        }
        // Moments about the means: t t, t b, b b, t y, b y.
        let mut m = [0.0; 5];
        for (point, weight) in points.iter().zip(weights) {
            let [t, b, y] = functions(point);
            let [t, b, y] = [t - mean[0], b - mean[1], y - mean[2]];
            m.iter_mut().zip([t * t, t * b, b * b, t * y, b * y]).for_each(|(sum, x)| *sum += weight * x);
        }
        let [tt, tb, bb, ty, by] = m;
        let (slope, bend) = if break_s.is_some() {
            let determinant = tt * bb - tb * tb;
            if determinant <= 1e-9 * tt * bb {
                return None;
            }
            ((ty * bb - by * tb) / determinant, (by * tt - ty * tb) / determinant)
        } else if tt > 0.0 {
            (ty / tt, 0.0)
        } else {
            return None;
        };
        let residual = |point: &Point| {
            let [t, b, y] = functions(point);
            (y - mean[2]) - slope * (t - mean[0]) - bend * (b - mean[1])
        };
        let squares = points.iter().zip(weights).map(|(point, weight)| weight * residual(point).powi(2)).sum();
        Some(Line { slope, bend, break_s: at, squares })
    }
}
