//! How the cost grows: with strokes, with bodies, with zones. In instructions, counted by callgrind, which repeat.
//!
//! `cargo bench -p erard-bench --bench scaling`, `-- --out DIR` for scaling.csv, scaling.svg and scaling.png. An
//! action's tree is two deep; a chain of levers is the hardest tree, for every joint moves all that hangs on it. Sizes
//! are those that instrument files may have. An exponent is the slope of log cost over log size: of the straight line
//! through all points, and between the last two.

mod levers;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use erard::player::Input;
use erard::run::Setup;
use erard_bench::callgrind::{CountError, instructions, is_available};
use erard_bench::{STEP_S, instrument};
use erard_figures::figure::chart_picture;
use erard_figures::figure::{Chart, ChartCurve, ChartPanel, Dash};
use erard_workshop::study::{Job, Lanes, Workers, play_all};
use levers::{BODIES, BODIES_AND_STOPS, Size, Stops, Tree, ZONES};
use moreau::Settings;

/// Steps of a tree that are counted.
const STEPS: u64 = 2000;
/// Duration of a stroke that is counted, s: from rest past the impact.
const STROKE_S: f64 = 0.05;
/// Strokes of a study.
const STROKES: [usize; 5] = [4, 8, 16, 32, 64];

/// What grows.
struct Series {
    name: &'static str,
    what: &'static str,
    /// Sizes, and the key of each on the command line.
    sizes: fn() -> Vec<usize>,
    /// Does the work of a size, or (false) all but it.
    go: fn(usize, bool),
    /// Parts by which the count is divided: steps, or nothing.
    per: u64,
}

const SERIES: [Series; 6] = [
    Series {
        name: "strokes",
        what: "strokes of a study, one core",
        sizes: || STROKES.to_vec(),
        go: |strokes, work| study(if work { strokes } else { 0 }),
        per: 1,
    },
    Series {
        name: "levers-alone",
        what: "bodies of a tree like an action's",
        sizes: || BODIES.iter().map(|s| s.bodies).collect(),
        go: |bodies, work| play(BODIES.iter().find(|s| s.bodies == bodies), Tree::Action, Stops::Far, work),
        per: STEPS,
    },
    Series {
        name: "levers-and-felts",
        what: "bodies of a tree like an action's, each between two felts",
        sizes: || BODIES_AND_STOPS.iter().map(|s| s.bodies).collect(),
        go: |bodies, work| {
            play(BODIES_AND_STOPS.iter().find(|s| s.bodies == bodies), Tree::Action, Stops::Pressed, work);
        },
        per: STEPS,
    },
    Series {
        name: "chain-and-felts",
        what: "bodies of a chain, each between two felts",
        sizes: || BODIES_AND_STOPS.iter().map(|s| s.bodies).collect(),
        go: |bodies, work| {
            play(BODIES_AND_STOPS.iter().find(|s| s.bodies == bodies), Tree::Chain, Stops::Pressed, work);
        },
        per: STEPS,
    },
    Series {
        name: "felts-pressed",
        what: "felts on six bodies, all of them pressed",
        sizes: || ZONES.iter().map(|s| s.zones).collect(),
        go: |zones, work| play(ZONES.iter().find(|s| s.zones == zones), Tree::Action, Stops::Pressed, work),
        per: STEPS,
    },
    Series {
        name: "felts-far",
        what: "felts on six bodies, none of them near",
        sizes: || ZONES.iter().map(|s| s.zones).collect(),
        go: |zones, work| play(ZONES.iter().find(|s| s.zones == zones), Tree::Action, Stops::Far, work),
        per: STEPS,
    },
];

fn play(size: Option<&Size>, tree: Tree, stops: Stops, work: bool) {
    size.expect("a size that is compiled").play(tree, stops, if work { STEPS } else { 0 });
}

/// A study of so many strokes, each on an instrument of its own.
fn study(strokes: usize) {
    let instruments = vec![instrument(); strokes];
    let setup = Setup { settings: Settings::new(STEP_S), ..Setup::new(STROKE_S) };
    let job = |i: usize| Job { instrument: i, stroke: Box::new(move |_| Input::Force(4.0 + 0.01 * i as f64)) };
    // Four: whatever more the processor has, so that counts can be compared.
    let workers = Workers { threads: 1, lanes: if Lanes::Four.is_here() { Lanes::Four } else { Lanes::One } };
    let played = play_all(&instruments, (0..strokes).map(job).collect(), &setup, workers, &mut |_| true);
    assert!(played.expect("nobody interrupts").iter().all(Result::is_ok));
}

/// A series counted.
struct Counted {
    series: &'static Series,
    sizes: Vec<f64>,
    counts: Vec<f64>,
}

fn count(series: &'static Series) -> Result<Counted, CountError> {
    let sizes = (series.sizes)();
    let mut counts = Vec::new();
    for size in &sizes {
        let of = |work| instructions(&["--count", series.name, "--size", &size.to_string(), "--work", work]);
        counts.push((of("all")? - of("none")?) as f64 / series.per as f64);
    }
    Ok(Counted { series, sizes: sizes.into_iter().map(|size| size as f64).collect(), counts })
}

impl Counted {
    /// Slope of the straight line through the logarithms, by least squares.
    fn exponent(&self) -> f64 {
        let (x, y): (Vec<f64>, Vec<f64>) = self.sizes.iter().zip(&self.counts).map(|(x, y)| (x.ln(), y.ln())).unzip();
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let (mx, my) = (mean(&x), mean(&y));
        let covariance: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
        covariance / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
    }

    /// Slope between the two largest sizes.
    fn last_exponent(&self) -> f64 {
        let [.., a, b] = self.sizes[..] else { return f64::NAN };
        let [.., ca, cb] = self.counts[..] else { return f64::NAN };
        (cb / ca).ln() / (b / a).ln()
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let after = |name: &str| arguments.iter().position(|a| a == name).and_then(|at| arguments.get(at + 1));
    if let Some(name) = after("--count") {
        let series = SERIES.iter().find(|series| series.name == name).expect("a series");
        let size = after("--size").and_then(|size| size.parse().ok()).expect("a size");
        (series.go)(size, after("--work").is_some_and(|work| work == "all"));
        return ExitCode::SUCCESS;
    }
    match run(after("--out").map(PathBuf::from)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(out: Option<PathBuf>) -> Result<(), Box<dyn std::error::Error>> {
    is_available()?;
    let mut all = Vec::new();
    for series in SERIES.iter() {
        let counted = count(series)?;
        print(&counted);
        all.push(counted);
    }
    let Some(folder) = out else { return Ok(()) };
    std::fs::create_dir_all(&folder)?;
    let mut csv = String::from("series,size,instructions\n");
    for counted in &all {
        for (size, count) in counted.sizes.iter().zip(&counted.counts) {
            writeln!(csv, "{},{size},{count}", counted.series.name)?;
        }
    }
    std::fs::write(folder.join("scaling.csv"), csv)?;
    let picture = chart_picture(&chart(&all), "scaling");
    std::fs::write(folder.join("scaling.svg"), picture.svg())?;
    std::fs::write(folder.join("scaling.png"), picture.png(2.0)?)?;
    Ok(())
}

#[allow(clippy::print_stdout, reason = "a benchmark prints its table")]
fn print(counted: &Counted) {
    let unit = if counted.series.per == 1 { "instructions" } else { "instructions a step" };
    println!("{}\n", counted.series.what);
    println!("  {:>6} {unit:>22}", "");
    for (size, count) in counted.sizes.iter().zip(&counted.counts) {
        println!("  {size:>6} {count:>22.0}");
    }
    println!("  exponent {:.2}, between the last two {:.2}\n", counted.exponent(), counted.last_exponent());
}

/// Cost over size, both logarithmic, with the exponents; a panel for strokes and one for the rest.
fn chart(all: &[Counted]) -> Chart {
    let curve = |colour: usize, counted: &Counted, scale: f64| ChartCurve {
        label: format!("{} ({:.2})", counted.series.name.replace('-', " "), counted.last_exponent()),
        x: counted.sizes.clone(),
        y: counted.counts.iter().map(|count| count * scale).collect(),
        colour,
        mark: Dash::Points,
    };
    // A line of a known slope through a point.
    let slope = |power: i32, label: &str, through: [f64; 2], to: f64| ChartCurve {
        label: label.into(),
        x: vec![through[0], to],
        y: vec![through[1], through[1] * (to / through[0]).powi(power)],
        colour: 6,
        mark: if power == 1 { Dash::Dashed } else { Dash::Dotted },
    };
    let (strokes, steps): (Vec<&Counted>, Vec<&Counted>) = all.iter().partition(|c| c.series.per == 1);
    let mut of_strokes: Vec<ChartCurve> = strokes.iter().map(|c| curve(0, c, 1e-6)).collect();
    let mut of_steps: Vec<ChartCurve> = steps.iter().enumerate().map(|(i, c)| curve(i + 1, c, 1e-3)).collect();
    if let Some(first) = of_strokes.first() {
        of_strokes.push(slope(1, "linear", [first.x[0], 0.7 * first.y[0]], 64.0));
    }
    if let Some(first) = of_steps.first() {
        let foot = [2.0, 0.6 * first.y[0]];
        of_steps.extend([slope(1, "linear", foot, 32.0), slope(2, "quadratic", foot, 14.0)]);
    }
    Chart {
        title: "Cost over size, in instructions (in brackets: the last exponent)".into(),
        caption: String::new(),
        x_label: "strokes; bodies or zones".into(),
        x_log: true,
        panels: vec![
            ChartPanel { y_label: "a study (millions)".into(), y_log: true, y_range: None, curves: of_strokes },
            ChartPanel { y_label: "a step (thousands)".into(), y_log: true, y_range: None, curves: of_steps },
        ],
    }
}
