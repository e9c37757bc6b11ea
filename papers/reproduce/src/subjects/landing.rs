//! A release compared with recorded ones: place of the hammer when the key comes home, rebound of the key, and its
//! duration.
//!
//! A checked hammer hangs some 30 mm above its rest and falls freely as soon as the repetition lever has met its stop.
//! It cannot come down faster than by its weight.

use super::release::Released;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Section, Table};
use erard::instrument::Instrument;
use moreau::Loss;

/// Two recorded releases, key and hammer: the author's action is mounted in its own frame, and the hammer has 50.8 mm
/// from rest to its stop (`recordings/README.md`).
const RECORDED: &str = include_str!("../../../../crates/erard-core/recordings/kawai-kg-3c-repeated.csv");
/// Times of the releases in it, s.
const RELEASES_S: [[f64; 2]; 2] = [[0.185, 0.37], [0.42, 0.60]];
/// Number of samples averaged.
const MEAN: usize = 5;
/// Travel above the held position at which a key has been released, m, and distance from rest at which key and hammer
/// are home, m.
const LEFT_M: f64 = 1e-3;
const HOME_M: f64 = 0.5e-3;
/// Time over which the key's speed is measured, s: before it is home, and beginning this long after its back has met
/// the cloth.
const SPEED_S: f64 = 2e-3;
const BOUNCED_S: f64 = 12e-3;

/// Course of a release; times after the key has left, s.
struct Course {
    left_s: f64,
    home_s: f64,
    /// Height of the hammer when the key was half-way, m, and when it was home.
    hung_m: f64,
    head_m: f64,
    /// Time at which the hammer is home.
    landed_s: f64,
    /// Rebound of the key, m, and time at which it is home again.
    rebound_m: f64,
    again_s: f64,
    /// Speeds of the key at its cloth, m/s: up, and down again.
    speeds_m_per_s: [f64; 2],
}

impl Course {
    /// Returns `None` if the key does not leave, come home, and come back.
    fn of(released: &Released) -> Option<Self> {
        let Released { time_s, key_m, head_m } = released;
        let from = |row: usize, is_it: &dyn Fn(f64) -> bool| Some(row + key_m[row..].iter().position(|&y| is_it(y))?);
        let deepest_m = key_m[..key_m.len() / 4].iter().copied().fold(0.0, f64::max);
        let held = from(0, &|y| y >= deepest_m)?;
        let left = from(held, &|y| y < deepest_m - LEFT_M)?;
        let half = from(left, &|y| y < 0.5 * deepest_m)?;
        let home = from(half, &|y| y < HOME_M)?;
        let back = from(home, &|y| y >= HOME_M)?;
        let again = from(back, &|y| y < HOME_M)?;
        let landed = home + head_m[home..].iter().position(|&y| y < HOME_M)?;
        let row = |s: f64| time_s.partition_point(|&t| t < s).min(time_s.len() - 1);
        let speed = |from_s: f64| {
            let (a, b) = (row(from_s), row(from_s + SPEED_S));
            (key_m[b] - key_m[a]) / (time_s[b] - time_s[a])
        };
        let since = |row: usize| time_s[row] - time_s[left];
        Some(Course {
            left_s: time_s[left],
            home_s: since(home),
            hung_m: head_m[half],
            head_m: head_m[home],
            landed_s: since(landed),
            rebound_m: key_m[back..again].iter().copied().fold(0.0, f64::max),
            again_s: since(again),
            speeds_m_per_s: [-speed(time_s[home] - SPEED_S), speed(time_s[home] + BOUNCED_S)],
        })
    }
}

/// A recorded release between two instants, s.
fn recorded([from_s, to_s]: [f64; 2]) -> Released {
    let rows: Vec<[f64; 3]> = RECORDED
        .lines()
        .filter_map(|line| {
            let mut cells = line.split(',').map(|cell| cell.parse().ok());
            Some([cells.next()??, cells.next()??, cells.next()??])
        })
        .filter(|row: &[f64; 3]| (from_s..to_s).contains(&row[0]))
        .collect();
    let mean = |column: usize, unit: f64| -> Vec<f64> {
        rows.windows(MEAN).map(|some| unit * some.iter().map(|row| row[column]).sum::<f64>() / MEAN as f64).collect()
    };
    Released { time_s: mean(0, 1.0), key_m: mean(1, 1e-3), head_m: mean(2, 1e-3) }
}

/// Acceleration of a free hammer at its head, m/s2: moments of weight less friction over inertia, with the line from
/// pin to centre of mass level and the bends locked.
fn free_fall(instrument: &Instrument) -> Option<f64> {
    let rigid = instrument.locked();
    let hammer = &rigid.bodies[rigid.roles.hammer?];
    let [arm_m, head_m] = [hammer.center_of_mass_m, rigid.roles.hammer_strike_point_m].map(|[x, y]| x.hypot(y));
    let torque_n_m = hammer.mass_kg * instrument.gravity_m_per_s2 * arm_m - hammer.friction_torque_n_m;
    Some(torque_n_m / hammer.inertia_kg_m2 * head_m)
}

/// Share of its speed returned by the back-rail cloth alone, in closed form: a rebound loses 2 eta / (1 + eta) of its
/// energy, times the mean of (1 - s_i)/(1 + s_i) over four sliders that slip one after the other; without b.
fn given_back(instrument: &Instrument) -> Option<f64> {
    let cloth = instrument.zones.iter().find(|zone| zone.name == "key_back_rail")?;
    let Loss::Iwan(law) = cloth.felt.loss else { return None };
    let left = (1..=4).map(|i| 0.25 * f64::from(i) * law.slip).map(|s| 0.25 * (1.0 - s) / (1.0 + s)).sum::<f64>();
    Some((1.0 - 2.0 * law.eta / (1.0 + law.eta) * left).sqrt())
}

/// Adds the comparison to the subject.
pub(super) fn add(instrument: &Instrument, free: &Released, section: &mut Section) {
    let recordings = RELEASES_S.map(recorded);
    let names = ["recorded, first", "recorded, second", "modelled"];
    let all = [&recordings[0], &recordings[1], free];
    let [Some(first), Some(second), Some(model)] = all.map(Course::of) else { return };
    let courses = [first, second, model];
    let Some(fall_m_per_s2) = free_fall(instrument) else { return };
    let header = [
        "release",
        "key up (ms)",
        "hammer at (mm)",
        "then (mm)",
        "free fall (ms)",
        "landed (ms)",
        "key back (mm)",
        "up again (ms)",
    ];
    let mut table = Table::new("A release beside recorded ones; times after the key has left", &header);
    let fall_s = |course: &Course| (2.0 * course.hung_m / fall_m_per_s2).sqrt();
    for (name, course) in names.iter().zip(&courses) {
        let ms = |s: f64| format!("{:.0}", 1e3 * s);
        let mm = |m: f64| format!("{:.1}", 1e3 * m);
        table.row([
            (*name).to_owned(),
            ms(course.home_s),
            mm(course.hung_m),
            mm(course.head_m),
            ms(fall_s(course)),
            ms(course.landed_s),
            mm(course.rebound_m),
            ms(course.again_s),
        ]);
    }
    section.tables.push(table);
    let each = |of: &dyn Fn(&Course) -> String| courses.iter().map(of).collect::<Vec<_>>().join(", ");
    section.claims.push(Claim::new(
        "recorded and modelled",
        "when the key is home the hammer has hardly begun to fall, in the recordings as in the model: from where it was checked no hammer falls home sooner",
        format!(
            "it is {} mm above its rest when the key is home after {} ms; a free fall ({fall_m_per_s2:.1} m/s2 at the head) takes {} ms, and it is home after {} ms",
            each(&|c| format!("{:.0}", 1e3 * c.head_m)),
            each(&|c| format!("{:.0}", 1e3 * c.home_s)),
            each(&|c| format!("{:.0}", 1e3 * fall_s(c))),
            each(&|c| format!("{:.0}", 1e3 * c.landed_s))
        ),
        courses.iter().all(|c| c.head_m > 0.8 * c.hung_m && c.landed_s > fall_s(c)),
    ));
    let [_, _, model] = &courses;
    let [up, down] = model.speeds_m_per_s;
    let longest = courses.iter().map(|c| c.again_s - c.home_s).fold(0.0, f64::max);
    let shortest = courses.iter().map(|c| c.again_s - c.home_s).fold(f64::INFINITY, f64::min);
    section.claims.push(Claim::new(
        "recorded and modelled",
        "the key comes back for as long as the hammer is in the air, in the recordings as in the model",
        format!(
            "for {} ms, by {} mm",
            each(&|c| format!("{:.0}", 1e3 * (c.again_s - c.home_s))),
            each(&|c| format!("{:.1}", 1e3 * c.rebound_m))
        ),
        longest < 1.5 * shortest,
    ));
    if let Some(cloth) = given_back(instrument) {
        let lies = instrument.lying().next().is_some();
        let (claim, holds) = if lies {
            (
                "the modelled key leaves its cloth with less than half of the speed that the cloth alone would give it: the rest lifts its pivot",
                down / up < 0.5 * cloth,
            )
        } else {
            (
                "the modelled key bounces as its cloth alone would let it, so that it is the cloth that gives the energy back",
                (down / up - cloth).abs() < 0.1,
            )
        };
        section.claims.push(Claim::new(
            "this program",
            claim,
            format!(
                "it arrives with {up:.2} m/s and leaves with {down:.2}, a share of {:.2}; the cloth's sliders by themselves return {cloth:.2}",
                down / up
            ),
            holds,
        ));
    }
    section.charts.push(chart(&all, &names, &courses));
}

fn chart(all: &[&Released; 3], names: &[&str; 3], courses: &[Course; 3]) -> Chart {
    let panel = |y_label: &str, of: fn(&Released) -> &[f64]| ChartPanel {
        y_label: y_label.into(),
        y_log: false,
        y_range: None,
        curves: all
            .iter()
            .zip(names)
            .zip(courses)
            .enumerate()
            .map(|(n, ((released, name), course))| {
                let time_ms = |t: &f64| 1e3 * (t - course.left_s);
                let shown = |t: &f64| (-15.0..150.0).contains(&time_ms(t));
                let (x, y) = released
                    .time_s
                    .iter()
                    .zip(of(released))
                    .filter(|(t, _)| shown(t))
                    .map(|(t, m)| (time_ms(t), 1e3 * m))
                    .unzip();
                let mark = if n == 2 { Dash::Solid } else { Dash::Dashed };
                ChartCurve { label: (*name).into(), x, y, colour: n, mark }
            })
            .collect(),
    };
    Chart {
        title: "A key let go, recorded and modelled".into(),
        caption: "0 ms: the key is a millimetre above where it was held. The recorded blow is 50.8 mm, the dip 11.7"
            .into(),
        x_label: "time (ms)".into(),
        x_log: false,
        panels: vec![panel("key front, down (mm)", |r| &r.key_m), panel("hammer above its rest (mm)", |r| &r.head_m)],
    }
}
