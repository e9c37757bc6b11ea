//! A mechanism that is no piano, for tests: a lever on the ground carrying a smaller one over a felt.

use erard::Impact;
use erard::instrument::{
    Body, Curve, DrawnPart, Felt, Finger, Instrument, InstrumentFields, Material, Origin, Roles, Zone,
};
use erard::player;
use erard::run::{BodySeries, Run};
use erard::run::{Setup, simulate};
use moreau::Settings;

fn body(name: &str, parent: Option<usize>, pivot_m: [f64; 2]) -> Body {
    Body {
        name: name.into(),
        parent,
        pivot_m,
        angle_rad: 0.1,
        mass_kg: 0.1,
        inertia_kg_m2: 1e-4,
        center_of_mass_m: [0.05, 0.0],
        friction_torque_n_m: 0.0,
        viscous_n_m_s: 0.0,
        dwell: None,
        is_bend: false,
        turn_rad: None,
    }
}

/// Two levers, one zone, no parts.
pub(crate) fn two_levers() -> Instrument {
    let fields = InstrumentFields {
        name: "Two levers".into(),
        gravity_m_per_s2: 9.81,
        bodies: vec![body("long", None, [0.01, 0.02]), body("short", Some(0), [0.1, 0.0])],
        springs: vec![],
        zones: vec![Zone {
            name: "stop".into(),
            label: "short lever - stop".into(),
            disc_body: Some(1),
            disc_center_m: [0.05, -0.002],
            disc_radius_m: 0.002,
            curve_body: None,
            curve: Curve::Line { point_m: [0.16, 0.01], normal: [0.0, 1.0] },
            felt: Felt { stiffness: 1e8, exponent: 2.0, ..Felt::default() },
            friction_coefficient: 0.0,
            dwell: None,
        }],
        strings: vec![],
        bridge_modes: vec![],
        roles: Roles::default(),
        finger: Finger { stiffness_n_per_m: 1e4, damping_n_s_per_m: 1.0 },
        screws: vec![],
        parts: vec![],
        origin: Origin::default(),
    };
    Instrument::new(fields).expect("its indices are in range")
}

/// The same with a drawn part that has a name meant to break out of the document.
pub(crate) fn two_levers_drawn() -> Instrument {
    let mut instrument = two_levers();
    instrument.rename("Two <levers> & \"more\" </script>");
    let part = DrawnPart {
        name: "stick </script><b>".into(),
        body: Some(0),
        material: Material::Wood,
        outline_m: vec![[0.0, -0.005], [0.1, -0.005], [0.1, 0.005], [0.0, 0.005]],
        smooth: false,
    };
    instrument.edit(|fields| fields.parts = vec![part]).expect("its body is there");
    instrument
}

/// A run of the two levers in which the stop is hit once, for a single frame.
///
/// The run is a real one of the grand, a moment at rest, with its series replaced: what else a run holds is not drawn.
pub(crate) fn two_levers_run(frames: usize) -> Run {
    let time_s: Vec<f64> = (0..frames).map(|i| i as f64 * 50e-6).collect();
    let hit = frames / 2;
    let angle = |scale: f64| time_s.iter().map(|t| 0.1 - scale * t).collect::<Vec<_>>();
    let series = |name: &str, scale| BodySeries {
        name: name.into(),
        angle_rad: angle(scale),
        rate_rad_per_s: vec![-scale; frames],
    };
    let mut run = at_rest();
    run.instrument = "Two levers".into();
    run.force_n = time_s.iter().map(|t| (t * 40.0).sin().abs()).collect();
    run.key_m = time_s.iter().map(|t| 0.01 * t).collect();
    run.hammer_rise_m = vec![];
    run.bodies = vec![series("long", 0.5), series("short", 1.0)];
    run.zones.truncate(1);
    let stop = &mut run.zones[0];
    stop.name = "stop".into();
    stop.label = "short lever - stop".into();
    stop.normal_n = (0..frames).map(|i| if i == hit { 25.0 } else { 0.0 }).collect();
    stop.tangential_n.clear();
    stop.contact = vec![[0.16, 0.01, 0.0, 1.0]; frames];
    let impact = |time_s: &f64| Impact { time_s: *time_s, hammer_speed_m_per_s: 1.0, hammer_speed_normal_m_per_s: 1.0 };
    run.events.impacts = time_s.get(hit).map(impact).into_iter().collect();
    run.time_s = time_s;
    run
}

fn at_rest() -> Run {
    let grand = Instrument::builtin("concert-grand").unwrap();
    let setup = Setup { settings: Settings::new(100e-6), ..Setup::new(200e-6) };
    let mut run = simulate(&grand, &|_| player::Input::Free, &setup, &mut |_| true).unwrap();
    run.events = erard::run::Events::default();
    run
}
