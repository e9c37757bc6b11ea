//! Mechanisms that can be made of any size: hanging levers with dry friction, and felt stops beside them.

use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;

use moreau::{
    Body, ContactCurve, Description, Exponent, Felt, GROUND, Loss, Model, Settings, Site, SiteInput, State,
    StepOutcome, Workspace, Zone, step,
};

/// How near the stops are.
#[derive(Clone, Copy, PartialEq)]
pub enum Stops {
    /// Never touched.
    Far,
    /// Always pressed, from both sides.
    Pressed,
}

/// What hangs on what.
#[derive(Clone, Copy, PartialEq)]
pub enum Tree {
    /// As in an action: of six levers the third and fourth hang on the second, the others on the ground.
    Action,
    /// Each on the one before.
    Chain,
}

impl Tree {
    fn parent(self, body: usize) -> usize {
        match (self, body % 6) {
            (Tree::Chain, _) if body > 0 => body - 1,
            (Tree::Action, 2) => body - 1,
            (Tree::Action, 3) => body - 2,
            _ => GROUND,
        }
    }
}

/// Length of a lever, m.
const LENGTH_M: f64 = 0.1;
/// Radius of what meets the stops, m.
const RADIUS_M: f64 = 0.005;
/// How far a stop presses into the felt, or stands off, m.
const PRESSED_M: f64 = 0.2e-3;
const FAR_M: f64 = 0.2;

/// Speed at which all levers start, to and fro in turn, rad/s: none of them stands still for long.
const SPEED_RAD_S: f64 = 2.0;

/// A tree of `bodies` levers and `zones` stops: along each lever, left and right in turn. Every fourth stop rubs.
fn levers<const B: usize, const Z: usize>(
    bodies: usize,
    zones: usize,
    tree: Tree,
    stops: Stops,
) -> (Model<f64, B, Z>, State<f64, B, Z>) {
    let levers: Vec<Body<f64>> = (0..bodies)
        .map(|i| Body {
            parent: tree.parent(i),
            pivot: if tree.parent(i) == GROUND { [0.0; 2] } else { [LENGTH_M, 0.0] },
            mass: 0.05,
            inertia: 0.05 * LENGTH_M * LENGTH_M / 3.0,
            center_of_mass: [0.5 * LENGTH_M, 0.0],
            dry: 2e-3,
            viscous: 1e-4,
        })
        .collect();
    let off_m = match stops {
        Stops::Far => FAR_M,
        Stops::Pressed => RADIUS_M - PRESSED_M,
    };
    let stops: Vec<Zone<f64>> = (0..zones)
        .map(|z| {
            let side = if z % 2 == 0 { 1.0 } else { -1.0 };
            let along = LENGTH_M * (0.9 - 0.2 * (z / 2 / bodies) as f64);
            Zone {
                disc_body: z / 2 % bodies,
                center: [along, 0.0],
                radius: RADIUS_M,
                curve_body: GROUND,
                curve: ContactCurve::Line { point: [side * off_m, 0.0], normal: [-side, 0.0] },
                felt: Felt { stiffness: 1e8, exponent: Exponent::Two, loss: Loss::quadratic(1e8) },
                friction: (z % 4 == 3).then_some(0.3),
            }
        })
        .collect();
    let site = Site { body: 0, point: [LENGTH_M, 0.0], direction: [1.0, 0.0], stiffness: 1e4, damping: 10.0 };
    let model =
        Description { bodies: &levers, zones: &stops, site: Some(site), gravity: 9.81, ..Description::default() }
            .compile()
            .expect("a sound tree");
    // Hanging: a lever's own axis points down.
    let mut angle = [0.0; B];
    angle[..bodies].fill(-FRAC_PI_2);
    let mut state = State::at_rest(angle);
    for (i, velocity) in state.velocity[..bodies].iter_mut().enumerate() {
        *velocity = if i % 2 == 0 { SPEED_RAD_S } else { -SPEED_RAD_S };
    }
    (model, state)
}

/// Pushes the first lever to and fro for so many steps.
fn play<const B: usize, const Z: usize, const N: usize>(
    [bodies, zones]: [usize; 2],
    tree: Tree,
    stops: Stops,
    steps: u64,
) {
    let (model, mut state) = levers::<B, Z>(bodies, zones, tree, stops);
    let (settings, mut workspace) = (Settings::new(50e-6), Workspace::<f64, B, Z, N>::new());
    for n in 0..steps {
        let force = if n / 400 % 2 == 0 { 2.0 } else { -2.0 };
        let report = step(&model, &settings, &SiteInput::Force(force), &mut state, &mut workspace);
        assert_ne!(report.outcome, StepOutcome::NonFinite);
    }
    black_box(state);
}

/// A size that is compiled: bodies, zones, and what plays it.
pub struct Size {
    /// Bodies.
    pub bodies: usize,
    /// Zones.
    pub zones: usize,
    play: fn([usize; 2], Tree, Stops, u64),
}

impl Size {
    /// Plays a tree of this size for so many steps.
    pub fn play(&self, tree: Tree, stops: Stops, steps: u64) {
        (self.play)([self.bodies, self.zones], tree, stops, steps);
    }
}

/// A law for every pivot and every rubbing stop, and one for a rigid drive.
macro_rules! size {
    ($b:literal, $z:literal) => {
        Size { bodies: $b, zones: $z, play: play::<$b, { if $z == 0 { 1 } else { $z } }, { $b + $z / 4 + 1 }> }
    };
}

/// Levers alone.
pub static BODIES: [Size; 7] =
    [size!(1, 0), size!(2, 0), size!(3, 0), size!(4, 0), size!(6, 0), size!(8, 0), size!(12, 0)];
/// Levers with two stops each.
pub static BODIES_AND_STOPS: [Size; 7] =
    [size!(1, 2), size!(2, 4), size!(3, 6), size!(4, 8), size!(6, 12), size!(8, 16), size!(12, 24)];
/// Six levers with more and more stops.
pub static ZONES: [Size; 5] = [size!(6, 4), size!(6, 8), size!(6, 16), size!(6, 24), size!(6, 32)];
