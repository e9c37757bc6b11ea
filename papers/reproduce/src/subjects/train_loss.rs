//! What heel and knuckles give back of a blow: a mass at the felt, over speed, static load and the loss of the felt's
//! sliders.
//!
//! The mass is the one that two parts of the action meet there. It rests on the felt under the load, is thrown into it,
//! and comes back; its largest speed on the way back, over the speed of the blow, squared, is the share of energy that
//! the felt gives back. The engine's numbers are compared with an integration of the written branches by the method of
//! Runge and Kutta, and with a closed form for slow blows.

use moreau::{
    Body, ContactCurve, Description, Exponent, Felt, GROUND, Iwan, Loss, Settings, SiteInput, State, StepOutcome,
    Workspace, Zone, step,
};

use super::impact::tell;
use super::{Claim, Progress, ReproduceError, Section, Table, bending};
use erard::instrument::{Instrument, InstrumentFile, Spread};
use erard::one_dof;

/// Felts of the train between key and hammer.
const HEEL: &str = "capstan_heel";
const KNUCKLES: [&str; 2] = ["jack_knuckle", "lever_knuckle"];
/// Speeds of the blow, m/s, and static loads, N: none, less and about as much as a heel bears at rest, and as under a
/// hand that presses.
const SPEEDS_M_PER_S: [f64; 5] = [0.05, 0.1, 0.2, 0.5, 1.0];
const LOADS_N: [f64; 4] = [0.0, 0.5, 2.0, 8.0];
/// Losses of the sliders (`iwan_loss`) beside the file's own.
const LOSSES: [f64; 4] = [0.3, 0.5, 0.7, 0.9];
/// Speed of a blow so slow that only the sliders take energy, m/s, and the difference allowed from the closed form.
const SLOW_M_PER_S: f64 = 1e-3;
const SLOW_CLOSE: f64 = 0.01;
/// Largest difference allowed between the engine and the Runge-Kutta method, of the ratio of speeds.
const CLOSE: f64 = 2e-3;
/// A file's loss is below this.
const MOST_LOSS: f64 = 0.99;
/// Ratios of speeds that the spread of a file shall cover: no loop of such a felt was found, so all that felts, cloths
/// and leathers may give back.
const COVERED: [f64; 2] = [0.3, 0.7];
/// Grand whose file says how far its losses may be off.
const FILE: &str = "concert-grand";
/// Arm of the mass, m, and length of the arm over the compression: the path is straight.
const ARM_M: f64 = 1.0;
/// Steps, s, of the engine and of the Runge-Kutta method, and time after which a blow ends, s.
const STEP_S: f64 = 2e-6;
const FINE_S: f64 = 1e-6;
const END_S: f64 = 0.2;

/// A felt with a mass at it.
#[derive(Clone, Copy)]
struct Bench {
    stiffness: f64,
    exponent: f64,
    law: Iwan<f64>,
    mass_kg: f64,
    load_n: f64,
}

impl Bench {
    /// With another loss of the sliders; the curve under load stays.
    fn losing(self, eta: f64) -> Self {
        let stiffness = self.stiffness * (1.0 + self.law.eta) / (1.0 + eta);
        Bench { stiffness, law: Iwan { eta, ..self.law }, ..self }
    }

    fn slips(self) -> [f64; 4] {
        [1.0, 2.0, 3.0, 4.0].map(|place| 0.25 * place * self.law.slip)
    }

    /// Half of r + 1: x = g^m.
    fn power(self) -> f64 {
        0.5 * (self.exponent + 1.0)
    }

    /// Compression under the load, pressed for the first time, m.
    fn rest_m(self) -> f64 {
        (self.load_n / (self.stiffness * (1.0 + self.law.eta))).powf(1.0 / self.exponent)
    }

    /// Largest speed on the way back over that of the blow, by the engine; `None` if a step does not converge, or the
    /// mass does not come back.
    fn by_engine(self, speed_m_per_s: f64) -> Option<f64> {
        let mass = self.mass_kg;
        let body = Body { mass, center_of_mass: [ARM_M, 0.0], inertia: mass * ARM_M * ARM_M, ..Body::inert() };
        let zone = Zone {
            disc_body: 0,
            center: [ARM_M, 0.0],
            radius: 0.0,
            curve_body: GROUND,
            curve: ContactCurve::Line { point: [ARM_M, 0.0], normal: [0.0, 1.0] },
            felt: Felt {
                stiffness: self.stiffness,
                exponent: Exponent::new(self.exponent),
                loss: Loss::Iwan(self.law),
            },
            friction: None,
        };
        let gravity = self.load_n / mass;
        let description = Description { bodies: &[body], zones: &[zone], gravity, ..Description::default() };
        let model = description.compile::<1, 1>().ok()?;
        let settings = Settings { tolerance: 1e-12, ..Settings::new(STEP_S) };
        let rest_m = self.rest_m();
        let mut state = State::at_rest([-(rest_m / ARM_M).asin()]);
        state.velocity = [-speed_m_per_s / ARM_M];
        // Every slider has slipped as the load came.
        state.memory[0] = self.slips().map(|slip| slip * rest_m.powf(self.power()));
        let mut workspace = Workspace::<f64, 1, 1, 2>::new();
        let mut before = state.velocity[0];
        for _ in 0..(END_S / STEP_S) as u32 {
            let report = step(&model, &settings, &SiteInput::Free, &mut state, &mut workspace);
            if report.outcome != StepOutcome::Converged {
                return None;
            }
            let now = state.velocity[0];
            // Nothing pushes any more, or less than the load.
            if before > 0.0 && now <= before {
                return Some(before * ARM_M / speed_m_per_s);
            }
            before = now;
        }
        None
    }

    /// Force of the sliders' springs and the felt's spring, N: pressed for the first time (`None`), or on the way back
    /// from the deepest compression, m.
    fn force_n(self, compression_m: f64, deepest_m: Option<f64>) -> f64 {
        let x = |g: f64| g.max(0.0).powf(self.power());
        let now = x(compression_m);
        let stretch = |slip: f64| {
            let e = deepest_m.map_or(slip * now, |deep| (slip * x(deep) - (x(deep) - now)).max(-slip * now));
            0.25 * self.law.eta / slip * e
        };
        let stretched: f64 = self.slips().into_iter().map(stretch).sum();
        self.stiffness * (now + stretched) * compression_m.max(0.0).powf(self.power() - 1.0)
    }

    /// The same ratio by the method of Runge and Kutta of fourth order on the written branches.
    fn by_runge_kutta(self, speed_m_per_s: f64) -> Option<f64> {
        let slope = |[g, v]: [f64; 2], deepest: Option<f64>| {
            let push_n = self.force_n(g, deepest) + self.law.damping * g.max(0.0) * g.max(0.0) * v;
            [v, (self.load_n - push_n.max(0.0)) / self.mass_kg]
        };
        let ahead = |[g, v]: [f64; 2], [dg, dv]: [f64; 2], h: f64| [g + h * dg, v + h * dv];
        let go = |at: [f64; 2], h: f64, deepest: Option<f64>| {
            let first = slope(at, deepest);
            let second = slope(ahead(at, first, 0.5 * h), deepest);
            let third = slope(ahead(at, second, 0.5 * h), deepest);
            let fourth = slope(ahead(at, third, h), deepest);
            let mean = |i: usize| (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]) / 6.0;
            [at[0] + h * mean(0), at[1] + h * mean(1)]
        };
        let (mut at, mut deepest) = ([self.rest_m(), speed_m_per_s], None);
        for _ in 0..(END_S / FINE_S) as u32 {
            let next = go(at, FINE_S, deepest);
            if deepest.is_none() && next[1] <= 0.0 {
                let turned = go(at, FINE_S * at[1] / (at[1] - next[1]), deepest);
                (at, deepest) = ([turned[0], 0.0], Some(turned[0]));
                continue;
            }
            if deepest.is_some() && next[1] >= at[1] {
                return Some(-at[1] / speed_m_per_s);
            }
            at = next;
        }
        None
    }

    /// The same ratio of a slow blow without a load, in closed form: the sliders alone.
    fn slow(self) -> f64 {
        let mean = self.slips().map(|slip| (1.0 - slip) / (1.0 + slip)).iter().sum::<f64>() / 4.0;
        (1.0 - 2.0 * self.law.eta / (1.0 + self.law.eta) * mean).sqrt()
    }
}

fn missing(what: &str) -> ReproduceError {
    ReproduceError::Instrument(format!("the instrument has no {what}"))
}

/// The felts of heel and knuckles, each with the mass that is met there: both sides' masses in series, with everything
/// held on its pivots. The key with what it carries comes from one side; the stack, or the hammer, from the other.
fn felts(instrument: &Instrument) -> Result<Vec<(&'static str, Bench)>, ReproduceError> {
    let one = one_dof::reduce(instrument)?;
    let rigid = instrument.locked();
    let key = rigid.roles.key.ok_or_else(|| missing("key"))?;
    let hammer = rigid.roles.hammer.ok_or_else(|| missing("hammer"))?;
    let whole = one.inertia_kg_m2;
    let of_key = rigid.bodies[key].inertia_kg_m2;
    let of_hammer = rigid.bodies[hammer].inertia_kg_m2;
    let ratio = one.ratios[hammer];
    let series = |a: f64, b: f64| a * b / (a + b);
    let bench = |name: &'static str| {
        let zone = rigid.zones.iter().find(|zone| zone.name == name);
        let zone = zone.ok_or_else(|| missing(&format!("zone `{name}`")))?;
        let Loss::Iwan(law) = zone.felt.loss else {
            return Err(ReproduceError::Instrument(format!("the felt of `{name}` has no `iwan_loss`")));
        };
        // The contacts are level at rest.
        let arm_m = zone.disc_center_m[0];
        let mass_kg = if name == HEEL {
            series(of_key, whole - of_key) / (arm_m * arm_m)
        } else {
            series(of_hammer, whole / (ratio * ratio) - of_hammer) / (arm_m * arm_m)
        };
        let (stiffness, exponent) = (zone.felt.stiffness, zone.felt.exponent);
        Ok((name, Bench { stiffness, exponent, law, mass_kg, load_n: 0.0 }))
    };
    let mut felts = vec![bench(HEEL)?, bench(KNUCKLES[0])?];
    // The knuckle is the same under jack and lever, as long as the file says so.
    let under_lever = bench(KNUCKLES[1])?;
    let under_jack = felts[1].1;
    if (under_lever.1.stiffness, under_lever.1.exponent, under_lever.1.law)
        != (under_jack.stiffness, under_jack.exponent, under_jack.law)
    {
        felts.push(under_lever);
    }
    Ok(felts)
}

/// The built-in file's number of a felt at a zone, and the ends of its spread.
fn spread(zone: &str, number: &str) -> Result<[f64; 3], ReproduceError> {
    let missing = || missing(&format!("spread of `{number}` of `{zone}` in {FILE}"));
    let file = InstrumentFile::builtin(FILE).ok_or_else(missing)?;
    let key = format!("zone.{zone}.felt.{number}");
    let found = file.provenance.numbers.iter().find(|number| number.key == key).ok_or_else(missing)?;
    let value = found.values[0];
    match found.citation.as_ref().and_then(|citation| citation.spread) {
        Some(Spread::PlusMinus(by)) => Ok([value, value - by, value + by]),
        Some(Spread::Factor(by)) => Ok([value, value / by, value * by]),
        None => Err(missing()),
    }
}

/// Least and largest ratio over all blows without a load, of losses at two ends, each with its factor of b.
fn covered(bench: Bench, ends: [[f64; 2]; 2]) -> [f64; 2] {
    let ends = ends.map(|[eta, b]| {
        let end = bench.losing(eta.clamp(0.0, MOST_LOSS));
        Bench { law: Iwan { damping: b * end.law.damping, ..end.law }, ..end }
    });
    let ratios = ends.into_iter().flat_map(|end| SPEEDS_M_PER_S.map(|speed| end.by_engine(speed).unwrap_or(f64::NAN)));
    ratios.fold([f64::INFINITY, 0.0], |[least, most], ratio| [least.min(ratio), most.max(ratio)])
}

pub(super) fn section(asked: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    tell(progress, 0.0)?;
    let felts = felts(&bending(asked)?)?;
    let mut header = vec!["loss".to_owned(), "load (N)".to_owned()];
    header.extend(SPEEDS_M_PER_S.map(|speed| format!("{speed} m/s")));
    header.push("slow".into());
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let (mut tables, mut worst, mut slow_worst, mut slow_most) = (Vec::new(), 0.0_f64, 0.0_f64, 0.0_f64);
    let count = (felts.len() * (1 + LOSSES.len())) as f64;
    let (mut loaded, mut fast) = (Vec::new(), Vec::new());
    for (n, (name, own)) in felts.iter().enumerate() {
        let mut table = Table::new(
            format!(
                "`{name}`, {:.0} g: share of the blow's energy given back, and the ratio of speeds",
                1e3 * own.mass_kg
            ),
            &header,
        );
        let losses = std::iter::once(own.law.eta).chain(LOSSES);
        for (m, eta) in losses.enumerate() {
            tell(progress, (n * (1 + LOSSES.len()) + m) as f64 / count)?;
            let bench = own.losing(eta);
            for load_n in LOADS_N {
                let bench = Bench { load_n, ..bench };
                let mut ratios = [f64::NAN; SPEEDS_M_PER_S.len()];
                for (ratio, speed) in ratios.iter_mut().zip(SPEEDS_M_PER_S) {
                    let pair = bench.by_engine(speed).zip(bench.by_runge_kutta(speed));
                    let [by_engine, by_hand] = pair.map_or([f64::NAN; 2], |(a, b)| [a, b]);
                    // A blow that did not come back counts as wrong.
                    let off = (by_engine - by_hand).abs();
                    worst = if off.is_nan() { f64::INFINITY } else { worst.max(off) };
                    *ratio = by_engine;
                }
                let cells = ratios.map(|ratio| format!("{:.2} ({ratio:.2})", ratio * ratio));
                let is_free = load_n == 0.0;
                let slow = bench.slow();
                let closed = if is_free { format!("{:.2} ({slow:.2})", slow * slow) } else { "-".into() };
                let of = if m == 0 { format!("{eta}, file") } else { format!("{eta}") };
                table.row([of, format!("{load_n}")].into_iter().chain(cells).chain([closed]));
                if is_free {
                    let found = bench.by_engine(SLOW_M_PER_S).unwrap_or(f64::NAN);
                    slow_worst = slow_worst.max((found - slow).abs());
                    slow_most = slow_most.max(if found.is_nan() { f64::INFINITY } else { found });
                }
                if m == 0 {
                    let [slowest, .., fastest] = ratios;
                    if is_free {
                        fast.push([slowest, fastest]);
                    }
                    loaded.push((load_n, slowest));
                }
            }
        }
        tables.push(table);
    }
    let mut claims = vec![
        Claim::new(
            "this program",
            format!("the engine's ratios are those of the Runge-Kutta method on the written branches, within {CLOSE}"),
            format!("within {worst:.0e}"),
            worst <= CLOSE,
        ),
        Claim::new(
            "this program",
            format!(
                "a slow blow does not come back whole: at {SLOW_M_PER_S} m/s the ratio is that of the closed form, within {SLOW_CLOSE}, and below 0.8"
            ),
            format!("within {slow_worst:.3}; {slow_most:.2} at the most"),
            slow_worst <= SLOW_CLOSE && slow_most < 0.8,
        ),
        Claim::new(
            "this program",
            "with the file's losses a fast blow gives back less than a slow one, at every felt: b takes the rest",
            fast.iter().map(|[slow, fast]| format!("{slow:.2} and {fast:.2}")).collect::<Vec<_>>().join("; "),
            fast.iter().all(|[slow, fast]| fast < slow),
        ),
        Claim::new(
            "this program",
            "a felt under a load gives back less of a slow blow than one without: the blow is a small loop on a large one",
            loaded.iter().map(|(load, ratio)| format!("{load} N {ratio:.2}")).collect::<Vec<_>>().join(", "),
            loaded.chunks(LOADS_N.len()).all(|of| of.windows(2).all(|pair| pair[1].1 < pair[0].1)),
        ),
    ];
    for (name, own) in &felts {
        let [loss, low, high] = spread(name, "iwan_loss")?;
        let [b, weak, strong] = spread(name, "damping_N_s_per_m3")?;
        let [least, most] = covered(*own, [[low, 1.0], [high, 1.0]]);
        let [too_least, too_most] = covered(*own, [[low, weak / b], [high, strong / b]]);
        claims.push(Claim::new(
            "this program",
            format!(
                "the spread of `iwan_loss` of `{name}` in the built-in grand covers ratios from {} to {}",
                COVERED[0], COVERED[1]
            ),
            format!(
                "{loss}, {low:.2} to {high:.2}, gives {least:.2} to {most:.2}; with that of b, too, {too_least:.2} to {too_most:.2}"
            ),
            least <= COVERED[0] && most >= COVERED[1],
        ));
    }
    Ok(Section {
        text: vec![
            "A mass rests on the felt under a load, with its sliders slipped as the load came; it is thrown into the felt \
             and comes back. Its largest speed on the way back, over that of the blow, is the ratio of speeds; its square \
             is the share of energy given back. The mass is what the two sides of the contact are in series, with \
             everything on its pivots: key and stack at the heel, hammer and the rest at the knuckle. With an exponent of \
             2 it counts only beside a load: b's part of the force, over the spring's, depends on the speed alone. Other losses keep the curve under load, (1 + loss) k. The last column is the \
             closed form of the sliders alone."
                .to_owned(),
            "No published loop of a heel, a knuckle or a back-rail cloth was found. M. Hirschkorn (thesis, Waterloo 2004) \
             and A. Thorin (thesis, Ecole polytechnique 2013) measured the contacts of their actions; only the beginnings \
             of both could be read. A. Stulov's loops are those of hammers. So the spread stands: ratios of 0.3 to 0.7."
                .to_owned(),
        ],
        claims,
        tables,
        ..Section::default()
    })
}
