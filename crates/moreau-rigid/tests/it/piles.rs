//! Piles of polygons: whatever happens, impulses are admissible, numbers are finite and the report says what was done.

use moreau::GROUND;
use moreau_rigid::{
    Body, Contact, Energies, ImpactLaw, Joint, JointKind, Model, Placement, PolygonContact, Settings, State,
    StepOutcome, Surface, Workspace, step,
};

const BODIES: usize = 5;
/// Each with each other, and with a floor and two walls.
const PAIRS: usize = BODIES * (BODIES - 1) / 2 + 3 * BODIES;
const LAWS: usize = 4 * PAIRS;

/// Uniform in [0, 1), xorshift64*.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Corners on a circle of 0.1 m, about their centre of mass, and its body of 1000 kg/m2.
fn polygon(corners: usize, random: &mut Random) -> (Vec<[f64; 2]>, Body<f64>) {
    let turn = std::f64::consts::TAU / corners as f64;
    let points: Vec<[f64; 2]> = (0..corners)
        .map(|k| {
            let (s, c) = (turn * (k as f64 + 0.5 * random.next())).sin_cos();
            [0.1 * c, 0.1 * s]
        })
        .collect();
    let (mut area, mut moment, mut second) = (0.0, [0.0; 2], 0.0);
    for k in 0..corners {
        let (a, b) = (points[k], points[(k + 1) % corners]);
        let cross = a[0] * b[1] - a[1] * b[0];
        area += 0.5 * cross;
        for i in 0..2 {
            moment[i] += cross * (a[i] + b[i]) / 6.0;
            second += cross * (a[i] * a[i] + a[i] * b[i] + b[i] * b[i]) / 12.0;
        }
    }
    let centre = [moment[0] / area, moment[1] / area];
    let inertia = 1000.0 * (second - area * (centre[0] * centre[0] + centre[1] * centre[1]));
    (points.iter().map(|p| [p[0] - centre[0], p[1] - centre[1]]).collect(), Body { mass: 1000.0 * area, inertia })
}

/// Five polygons of three to six corners tumble into a box half a metre wide.
fn tumble(seed: u64, law: ImpactLaw) -> [u32; 4] {
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let parts: Vec<_> = (0..BODIES).map(|i| polygon(3 + i % 4, &mut random)).collect();
    let bodies: Vec<_> = parts.iter().map(|(_, body)| *body).collect();
    let floor = [[-2.0, -1.0], [2.0, -1.0], [2.0, 0.0], [-2.0, 0.0]];
    let left = [[-1.25, -0.5], [-0.25, -0.5], [-0.25, 5.0], [-1.25, 5.0]];
    let right = [[0.25, -0.5], [1.25, -0.5], [1.25, 5.0], [0.25, 5.0]];
    let mu = 0.2 + 0.6 * random.next();
    let pair = |first: usize, second: usize, corners| PolygonContact {
        first,
        first_corners: &parts[first].0[..],
        second,
        second_corners: corners,
        restitution: 0.4,
        kinetic: mu,
        limit: mu,
    };
    let mut pairs = Vec::new();
    for i in 0..BODIES {
        for corners in [&floor[..], &left, &right] {
            pairs.push(pair(i, GROUND, corners));
        }
        for (j, (corners, _)) in parts.iter().enumerate().take(i) {
            pairs.push(pair(i, j, corners));
        }
    }
    let model = Model::new(&bodies, &[], &[], &[], [0.0, -9.81]).unwrap().with_polygons(&pairs).unwrap();
    let start: Vec<_> = (0..BODIES)
        .map(|i| {
            let at = [0.2 * random.next() - 0.1, 0.15 + 0.25 * i as f64];
            let v = [random.next() - 0.5, -random.next(), 10.0 * random.next() - 5.0];
            (Placement { at, angle: 6.0 * random.next() }, v)
        })
        .collect();
    let mut state = Box::new(State::<f64, BODIES, LAWS>::new(&start));
    let mut workspace = Box::new(Workspace::new());
    let h = 5e-4;
    let settings = Settings { impact_law: law, ..Settings::new(h) };
    let mut outcomes = [0; 4];
    let mut energy = Energies::of(&model, &state).total();
    let begin = energy;
    let mass: f64 = bodies.iter().map(|b| b.mass).sum();
    for n in 0..3000 {
        let report = step(&model, &settings, &[], &mut state, &mut workspace);
        outcomes[match report.outcome {
            StepOutcome::Converged => 0,
            StepOutcome::Approximate => 1,
            StepOutcome::Painleve => 2,
            StepOutcome::IterationLimit => 3,
            other => panic!("seed {seed}, step {n}: {other:?}"),
        }] += 1;
        assert!(report.residual < 1e-3, "seed {seed}, step {n}: {report:?}");
        for c in 0..PAIRS {
            for k in 0..2 {
                let [normal, friction] = model.polygon_laws(c, k).map(|i| state.impulse[i]);
                assert!(normal >= 0.0, "seed {seed}, step {n}: a contact pulls with {normal}");
                assert!(friction.abs() <= mu * normal + 1e-12, "seed {seed}, step {n}: {friction} of {normal}");
            }
        }
        let after = Energies::of(&model, &state).total();
        if law == ImpactLaw::Stronge {
            // What comes to rest in a step may give m (g h)2/8; what else the step gives is of the order of h times an
            // impact's change.
            let bound = 1e-2 * (energy - begin).abs().max(0.1 * begin.abs());
            assert!(after - energy <= bound, "seed {seed}, step {n}: {} J, {report:?}", after - energy);
        }
        energy = after;
    }
    for (i, place) in state.placement.iter().enumerate() {
        let inside = place.at[0].abs() < 0.25 && place.at[1] > 0.0 && place.at[1] < 2.0;
        assert!(inside, "seed {seed}: body {i} at {:?}", place.at);
    }
    let kinetic = Energies::of(&model, &state).kinetic;
    assert!(kinetic < 1e-20 * mass, "seed {seed}: {kinetic} J left after 1.5 s");
    outcomes
}

#[test]
fn piles_stay_admissible() {
    let mut all = [0; 4];
    for (seed, law) in [(3, ImpactLaw::Newton), (4, ImpactLaw::Stronge)] {
        for (sum, x) in all.iter_mut().zip(tumble(seed, law)) {
            *sum += x;
        }
    }
    // A corner in a corner sticks to the floor and leans on the wall: two laws of nearly one velocity, which sweeps end
    // slowly.
    assert!(all[0] > 5_700 && all[3] == 0, "{all:?}");
}

/// A chain of five bars on hinges falls on a rough floor: joints, friction and several contacts at once. Steps are
/// sound with either law, and by Stronge's no impact gives energy.
#[test]
fn a_chain_falls() {
    let (bars, half, mu) = (5, 0.1, 0.5);
    let bodies = vec![Body { mass: 0.2, inertia: 0.2 * half * half / 3.0 }; bars];
    let hinge = |i: usize| Joint {
        kind: JointKind::Hinge,
        first: i,
        at_first: [half, 0.0],
        second: i + 1,
        at_second: [-half, 0.0],
        dry: 0.0,
        viscous: 0.0,
        rate: None,
    };
    let joints: Vec<_> = (0..bars - 1).map(hinge).collect();
    let end = |body: usize, x: f64| Contact {
        disc_body: body,
        center: [x, 0.0],
        radius: 0.01,
        surface_body: GROUND,
        surface: Surface::Line { point: [0.0, 0.0], normal: [0.0, 1.0] },
        restitution: 0.5,
        kinetic: mu,
        limit: 1.2 * mu,
        belt: 0.0,
    };
    let contacts: Vec<_> = (0..bars).map(|i| end(i, -half)).chain([end(bars - 1, half)]).collect();
    let model = Model::new(&bodies, &joints, &[], &contacts, [0.0, -9.81]).unwrap();
    for law in [ImpactLaw::Newton, ImpactLaw::Stronge] {
        let mut impacts = 0;
        for seed in 1..=2u64 {
            let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
            let mut at = [0.0, 0.6 + 0.2 * random.next()];
            let mut start = Vec::new();
            for _ in 0..bars {
                let angle: f64 = 3.0 * random.next() - 1.5;
                let (s, c) = angle.sin_cos();
                start.push((Placement { at: [at[0] + half * c, at[1] + half * s], angle }, [0.5, -1.0, 0.0]));
                at = [at[0] + 2.0 * half * c, at[1] + 2.0 * half * s];
            }
            let mut state = State::<f64, 5, 24>::new(&start);
            let mut workspace = Workspace::new();
            let settings = Settings { impact_law: law, ..Settings::new(1e-4) };
            let begin = Energies::of(&model, &state).total();
            let mut energy = begin;
            for n in 0..10_000 {
                let report = step(&model, &settings, &[], &mut state, &mut workspace);
                let sound =
                    matches!(report.outcome, StepOutcome::Converged | StepOutcome::Approximate | StepOutcome::Painleve);
                assert!(sound, "{law:?} {seed}, step {n}: {report:?}");
                assert!(report.residual < 1e-2, "{law:?} {seed}, step {n}: {report:?}");
                impacts += u32::from(report.impact_energy < 0.0);
                let gave = law == ImpactLaw::Stronge && report.impact_energy > 1e-13 * begin;
                assert!(!gave, "{seed}, step {n}: {report:?}");
                for c in 0..contacts.len() {
                    let [normal, friction] = model.contact_laws(c).map(|i| state.impulse[i]);
                    assert!(normal >= 0.0 && friction.abs() <= 1.2 * mu * normal + 1e-13, "{normal} {friction}");
                }
                let after = Energies::of(&model, &state).total();
                // What the step itself gives is of order h: a free chain at 1e-4 s some 4e-8 of its energy.
                let most = if law == ImpactLaw::Stronge { 1e-6 } else { 1.0 };
                assert!(after - energy < most * begin, "{law:?} {seed}, step {n}: {} J, {report:?}", after - energy);
                energy = after;
            }
        }
        assert!(impacts > 100, "{law:?}: {impacts}");
    }
}
