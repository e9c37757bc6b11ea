//! Three levers with discs on lines: the papers' levers as a special case, and what a radius changes.

use std::f64::consts::{FRAC_PI_2, PI};

use erard_kinematics::three_lever::{DiscLevers, Drive, Levers, Line, Move, Regulation, StrokePose, ThreeLever, Touch};

/// The papers' contacts as discs without a radius: the heel's point on the key, the knuckle's on the jack.
fn papers(levers: &ThreeLever) -> DiscLevers {
    let l = levers.lengths;
    DiscLevers {
        whippen_pivot: [l.l1, l.l5],
        hammer_pivot: [l.l1 - l.l6, l.l5 + l.l10],
        capstan: Touch {
            disc_on_whippen: true,
            center: [l.l3, -l.l4],
            offset: 0.0,
            line: Line { point: [l.l2, 0.0], angle: FRAC_PI_2 },
        },
        knuckle: Touch {
            disc_on_whippen: false,
            center: [l.l8, -l.l9],
            offset: 0.0,
            line: Line { point: [0.0, -l.l7], angle: PI },
        },
        key_front: levers.key_front,
        key_rest: levers.key_rest,
        head: levers.head,
        near: [0.0, -0.3],
    }
}

/// An instrument's contacts: a dome of 10 mm under a level heel, a roller of 5 mm on the jack; a little askew.
fn instrument() -> DiscLevers {
    DiscLevers {
        capstan: Touch {
            disc_on_whippen: false,
            center: [0.01832, -0.14223],
            offset: -0.010,
            line: Line { point: [-0.063, -0.01618], angle: 0.002 },
        },
        knuckle: Touch {
            disc_on_whippen: false,
            center: [0.017, -0.0048],
            offset: -0.005,
            line: Line { point: [-0.080, 0.04837], angle: PI - 0.003 },
        },
        ..papers(&ThreeLever::c7f_like())
    }
}

fn poses(levers: &DiscLevers) -> Vec<StrokePose> {
    let stroke = levers.assemble().unwrap().stroke(0.0, 0.0075, 300);
    assert_eq!(stroke.stop, None);
    stroke.poses
}

/// With points instead of discs and the papers' carriers, every number of every pose is the
/// papers' to rounding: lengths of 0.2 m and a condition number below 100 leave 1e-13.
#[test]
fn the_papers_levers_are_a_special_case() {
    for levers in [ThreeLever::c7f_like(), ThreeLever::steinway_o_like()] {
        let discs = papers(&levers);
        let [ours, theirs] = [Levers::from(discs), levers.into()].map(|l| l.assemble().unwrap());
        assert_eq!(ours.levers().hammer_pivot(), theirs.levers().hammer_pivot());
        assert!((ours.rest_head_height() - theirs.rest_head_height()).abs() < 1e-13);
        let [a, b] = [&ours, &theirs].map(|train| train.stroke(0.0, 0.008, 100).poses);
        for (a, b) in a.iter().zip(&b) {
            let pairs = [(a.w, b.w), (a.h, b.h), (a.s1, b.s1), (a.s2, b.s2), (a.head_rise, b.head_rise)];
            assert!(pairs.iter().all(|(a, b)| (a - b).abs() < 1e-13), "{pairs:?}");
            assert!((a.leverage - b.leverage).abs() < 1e-11);
            assert!((a.capstan_sliding - b.capstan_sliding).abs() < 1e-13);
            assert!((a.knuckle_sliding - b.knuckle_sliding).abs() < 1e-13);
            let [ours, theirs] = [ours.levers().lever_arms(a), theirs.levers().lever_arms(b)];
            assert!((ours.product() - theirs.product()).abs() < 1e-11);
        }
        for moves in [[Move::Capstan(-0.010)], [Move::Knuckle(-0.003)], [Move::HeelDepth(0.001)]] {
            for regulation in [Regulation::Regulated, Regulation::AsMoved] {
                let ours = Levers::from(discs).moved(&moves, regulation).unwrap().assemble().unwrap().rest();
                let theirs = Levers::from(levers).moved(&moves, regulation).unwrap().assemble().unwrap().rest();
                assert!((ours.leverage - theirs.leverage).abs() < 1e-11, "{moves:?} {regulation:?}");
                assert!((ours.h - theirs.h).abs() < 1e-12);
            }
        }
    }
}

/// The equations of an instrument, sign by sign: the capstan's centre on the key, its line on
/// the whippen. A level heel and jack leave out what is zero.
#[test]
fn equations() {
    let print = |levers: DiscLevers| -> Vec<String> {
        let mechanism = levers.linkage(Drive::Key).assemble().unwrap();
        mechanism.equations().iter().map(ToString::to_string).collect()
    };
    let mut level = instrument();
    level.capstan.line.angle = 0.0;
    level.knuckle.line.angle = PI;
    level.capstan.line.point[0] = 0.0;
    level.knuckle.line.point[0] = 0.0;
    assert_eq!(
        print(level),
        [
            "C1 cos k - C2 sin k + E2 sin w - S1 cos w - L1 = 0",
            "C1 sin k + C2 cos k - E2 cos w - S1 sin w - L5 = 0",
            "L8 cos h + J2 sin w + L9 sin h + S2 cos w - L6 = 0",
            "L8 sin h - J2 cos w - L9 cos h + S2 sin w + L10 = 0",
        ]
    );
    assert!(print(instrument())[0].contains("S1 cos(w + e)"), "{:?}", print(instrument()));
}

/// Leverage is the derivative of the rise (central differences over 2 x 1 µm: 1e-6), and every
/// pose closes to 1e-12.
#[test]
fn leverage_agrees_with_differences() {
    let train = instrument().assemble().unwrap();
    for i in 1..70 {
        let key = f64::from(i) * 1e-4;
        let poses = train.stroke(key - 1e-6, key + 1e-6, 2).poses;
        let difference = (poses[2].head_rise - poses[0].head_rise) / 2e-6;
        assert!((poses[1].leverage - difference).abs() < 1e-6);
        assert!(poses[1].residual < 1e-12);
    }
}

/// The disc's centre keeps its distance from the line: the point of contact, seen from the whippen,
/// lies on the heel, and on the jack's top (1e-12 m: rounding), and S2 is where on it.
#[test]
fn contact_points_lie_on_the_lines() {
    let levers = instrument();
    for pose in poses(&levers) {
        let points = levers.contact_points(&pose);
        let lines = [levers.capstan.line, levers.knuckle.line];
        for (point, line) in points.into_iter().zip(lines) {
            let (s, c) = pose.w.sin_cos();
            let [x, y] = [point[0] - levers.whippen_pivot[0], point[1] - levers.whippen_pivot[1]];
            let [x, y] = [c * x + s * y - line.point[0], c * y - s * x - line.point[1]];
            assert!((y * line.angle.cos() - x * line.angle.sin()).abs() < 1e-12);
        }
    }
}

/// Sliding is the way of the two surfaces along each other: of the contact's place on the line, less
/// the arc that it moves around the disc. Found here from the places of the contact in both bodies
/// (sums of 300 small chords miss the arc by less than 1e-9 m).
#[test]
fn sliding_is_what_the_surfaces_slip() {
    let levers = instrument();
    let poses = poses(&levers);
    let seen = |point: [f64; 2], pivot: [f64; 2], angle: f64| {
        let (s, c) = angle.sin_cos();
        let [x, y] = [point[0] - pivot[0], point[1] - pivot[1]];
        [c * x + s * y, c * y - s * x]
    };
    let mut slip = [0.0; 2];
    for two in poses.windows(2) {
        let places = |pose: &StrokePose| {
            let [capstan, knuckle] = levers.contact_points(pose);
            let whippen = [capstan, knuckle].map(|point| seen(point, levers.whippen_pivot, pose.w));
            let other = [seen(capstan, [0.0; 2], pose.k), seen(knuckle, levers.hammer_pivot, pose.h)];
            (whippen, other)
        };
        let (before, after) = (places(&two[0]), places(&two[1]));
        for contact in 0..2 {
            // Along the line as it is in the whippen's frame at the middle of the step.
            let line = [levers.capstan.line, levers.knuckle.line][contact];
            let on_line = [0, 1].map(|i| after.0[contact][i] - before.0[contact][i]);
            let along = on_line[0] * line.angle.cos() + on_line[1] * line.angle.sin();
            let middle = |f: fn(&StrokePose) -> f64| 0.5 * (f(&two[0]) + f(&two[1]));
            let turned = middle(|p| p.w) - if contact == 0 { middle(|p| p.k) } else { middle(|p| p.h) };
            let angle = line.angle + turned;
            let on_disc = [0, 1].map(|i| after.1[contact][i] - before.1[contact][i]);
            slip[contact] += along - (on_disc[0] * angle.cos() + on_disc[1] * angle.sin());
        }
    }
    let last = poses.last().unwrap();
    let place = last.s2 - poses[0].s2;
    println!("slid {slip:?} m; the knuckle's place on the jack moved by {place} m");
    assert!((slip[0] - last.capstan_sliding).abs() < 1e-9);
    assert!((slip[1] - last.knuckle_sliding).abs() < 1e-9);
    assert!((place - slip[1]).abs() > 1e-3, "a knuckle of 5 mm that turns 0.3 rad rolls more than a millimetre");
}

/// Regulation keeps the hammer's rest to rounding; the moved capstan has two arms 10 mm longer and
/// shorter, a level heel or not.
#[test]
fn regulation_keeps_the_hammer_at_rest() {
    let levers = instrument();
    let rest = levers.assemble().unwrap().rest();
    for part in [
        Move::Capstan(-0.010),
        Move::Knuckle(-0.003),
        Move::CapstanHeight(0.001),
        Move::HeelDepth(0.002),
        Move::KnuckleDepth(0.001),
        Move::JackHeight(-0.001),
        Move::WhippenPivot(0.002, -0.001),
        Move::HammerPivot(-0.002, 0.001),
    ] {
        let moved = levers.moved(&[part], Regulation::Regulated).unwrap();
        assert!((moved.assemble().unwrap().rest().h - rest.h).abs() < 1e-12, "{part:?}");
        let left = levers.moved(&[part], Regulation::AsMoved).unwrap();
        let sunk_or_risen = (left.assemble().unwrap().rest().h - rest.h).abs();
        assert!(sunk_or_risen > 1e-6, "{part:?} {sunk_or_risen}");
    }
    let arms = |levers: &DiscLevers| Levers::from(*levers).lever_arms(&levers.assemble().unwrap().rest());
    let [before, after] =
        [levers, levers.moved(&[Move::Capstan(-0.010)], Regulation::Regulated).unwrap()].map(|l| arms(&l));
    // A tenth of a millimetre: the arms are not quite level.
    assert!((after.key_back - before.key_back + 0.010).abs() < 3e-4);
    assert!((after.whippen_heel - before.whippen_heel - 0.010).abs() < 5e-4);
}

/// The key's angle under a whippen's is the inverse of the stroke (1e-12 rad).
#[test]
fn key_under_a_whippen() {
    let levers = instrument();
    for pose in poses(&levers) {
        assert!((levers.key_under(pose.w).unwrap() - pose.k).abs() < 1e-12);
    }
}
