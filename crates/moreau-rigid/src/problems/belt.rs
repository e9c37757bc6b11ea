//! Problem 9: a mass on a belt, held by a spring. Mass, stiffness and kinetic friction limit 1, belt speed 0.2,
//! dimensionless.

use crate::{Body, Contact, Mode, Model, Spring, Surface};
use moreau::GROUND;

use super::row::ProblemRow;
use super::run::{Run, at};

const BELT: f64 = 0.2;
/// Weight of the mass; with a friction coefficient of a tenth, the limit is 1.
const WEIGHT: f64 = 10.0;

/// Instants at which slipping begins and ends, and the largest |x - 1 - 0.2 sin(t - 5)| from t = 5 to 11.
struct Course {
    slips: Vec<f64>,
    sticks: Vec<f64>,
    deviation: f64,
    sound: bool,
}

fn course(limit: f64, h: f64, duration: f64) -> Course {
    let bodies = [Body { mass: 1.0, inertia: 1.0 }];
    let springs = [Spring {
        first: GROUND,
        at_first: [-10.0, 0.0],
        second: 0,
        at_second: [0.0, 0.0],
        stiffness: 1.0,
        damping: 0.0,
        length: 10.0,
    }];
    let contacts = [Contact {
        disc_body: 0,
        center: [0.0, 0.0],
        radius: 0.0,
        surface_body: GROUND,
        surface: Surface::Line { point: [0.0, 0.0], normal: [0.0, 1.0] },
        restitution: 0.0,
        kinetic: 1.0 / WEIGHT,
        limit: limit / WEIGHT,
        belt: BELT,
    }];
    let model = Model::new(&bodies, &[], &springs, &contacts, [0.0, -WEIGHT]).expect("sound");
    let mut run = Run::<1, 2>::new(model, h, &[(at(0.0, 0.0, 0.0), [BELT, 0.0, 0.0])]);
    let tangential = model.contact_laws(0)[1];
    let mut course = Course { slips: Vec::new(), sticks: Vec::new(), deviation: 0.0, sound: true };
    let mut sticking = true;
    while run.time() < duration && run.sound {
        run.step();
        let holds = run.state.mode[tangential] == Mode::Hold;
        // What changed did so within the step: its middle.
        let t = run.time();
        if sticking && !holds {
            course.slips.push(t - 0.5 * h);
        } else if !sticking && holds {
            course.sticks.push(t - 0.5 * h);
        }
        sticking = holds;
        if (5.0..11.0).contains(&t) {
            let x = run.state.placement[0].at[0];
            course.deviation = course.deviation.max((x - 1.0 - BELT * (t - 5.0).sin()).abs());
        }
    }
    course.sound = run.sound;
    course
}

/// Slipping of the limit cycle with a static limit of 1.5: the mass leaves the belt at x = 1.5 and comes back to its
/// speed after 2 pi - 2 atan(0.5 / 0.2).
pub(crate) fn slip_duration() -> f64 {
    2.0 * std::f64::consts::PI - 2.0 * (0.5_f64 / BELT).atan()
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    for h in [1e-2, 1e-3, 1e-4] {
        let c = course(1.0, h, 11.0);
        let first = |v: &[f64]| if c.sound { v.first().copied().unwrap_or(f64::NAN) } else { f64::NAN };
        rows.push(ProblemRow::new(format!("slips at, h = {h:.0e}"), "", 5.0, first(&c.slips), h, "known to a step"));
        let because = "a shift of the onset by a step moves x by 0.2 h at most";
        rows.push(ProblemRow::new(
            format!("largest |x - 1 - 0.2 sin(t - 5)|, h = {h:.0e}"),
            "",
            0.0,
            if c.sound { c.deviation } else { f64::NAN },
            0.2 * h,
            because,
        ));
    }
    for h in [1e-2, 1e-3, 1e-4] {
        let c = course(1.5, h, 26.0);
        let instant = |v: &[f64], i: usize| if c.sound { v.get(i).copied().unwrap_or(f64::NAN) } else { f64::NAN };
        let (slip, stick) = (instant(&c.slips, 0), instant(&c.sticks, 0));
        let again = instant(&c.slips, 1);
        let because = "two instants, each known to a step";
        let slipping = slip_duration();
        let mut add = |name: &str, reference, ours| {
            rows.push(ProblemRow::new(
                format!("static limit 1.5: {name}, h = {h:.0e}"),
                "",
                reference,
                ours,
                2.0 * h,
                because,
            ));
        };
        add("slips for", slipping, stick - slip);
        add("sticks for", 5.0, again - stick);
        add("period", slipping + 5.0, again - slip);
    }
    rows
}
