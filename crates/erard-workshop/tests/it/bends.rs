//! A grand with flexible key and shank is measured, reduced and derived like the rigid one it was made from.

use std::path::Path;

use erard::grand::Anatomy;
use erard::instrument::Instrument;
use erard::one_dof;
use erard::player::{RestKind, RestPose};
use erard_kinematics::derive;
use erard_workshop::distances::{self, Protocol};
use erard_workshop::measure::inertia::inertia;
use erard_workshop::measure::range::softest;
use erard_workshop::measure::weights::on_the_scale;

fn both() -> [Instrument; 2] {
    let path = format!("{}/../erard-core/tests/bending/8-bodies.toml", env!("CARGO_MANIFEST_DIR"));
    [Instrument::builtin("concert-grand-rigid").unwrap(), Instrument::load(Path::new(&path)).unwrap()]
}

fn near(a: f64, b: f64, within: f64, what: &str) {
    assert!((a - b).abs() <= within, "{what}: {a} beside {b}");
}

/// The parts on the scale are those of the rigid action; masses of the pieces are rounded in their file.
#[test]
fn the_scale_sees_whole_parts() {
    let [rigid, bent] = both().map(|i| on_the_scale(&i, 6e-3, [1e-3, 5e-3]).unwrap());
    near(bent.0.strike_weight_g, rigid.0.strike_weight_g, 5e-3, "strike weight");
    near(bent.0.front_weight_g, rigid.0.front_weight_g, 0.05, "front weight");
    near(bent.0.whippen_weight_g, rigid.0.whippen_weight_g, 0.02, "whippen weight");
    near(bent.1.half_way, rigid.1.half_way, 5e-3, "ratio");
    let [rigid, bent] = both().map(|i| inertia(&i, 6e-3, &mut |_| true).unwrap().half_way);
    near(bent.hammer_kg, rigid.hammer_kg, 2e-3 * rigid.hammer_kg, "hammer");
    near(bent.key_kg, rigid.key_kg, 2e-3 * rigid.key_kg, "key");
}

/// Three levers and one degree of freedom are those of the rigid action.
#[test]
fn geometry_is_rigid() {
    let [rigid, bent] = both().map(|i| derive(&i).unwrap().levers);
    for (a, b, what) in [
        (bent.key_front, rigid.key_front, "key front"),
        (bent.head[0], rigid.head[0], "strike point"),
        (bent.hammer_pivot[1], rigid.hammer_pivot[1], "centre"),
    ] {
        near(a, b, 1e-5, what);
    }
    let [rigid, bent] = both().map(|i| one_dof::reduce(&i).unwrap());
    near(bent.inertia_kg_m2, rigid.inertia_kg_m2, 2e-3 * rigid.inertia_kg_m2, "inertia");
    near(bent.moment_n_m, rigid.moment_n_m, 5e-3 * rigid.moment_n_m.abs(), "moment");
}

/// Roles that name the end of a chain are found; distances are those set by the screws (as drawn: so they were set),
/// although the key bends under the finger.
#[test]
fn distances_are_found_in_what_bends() {
    let [_, bent] = both();
    let parts = Anatomy::find(&bent).unwrap();
    let name = |body: Option<usize>| bent.bodies[body.unwrap()].name.as_str();
    assert_eq!([name(Some(parts.key)), name(Some(parts.hammer)), name(parts.damper)], ["key", "hammer", "damper"]);
    let drawn = RestPose::of(&bent, RestKind::AsDrawn, &mut |_| true).unwrap();
    let found = distances::measure(&drawn, &Protocol::default(), &mut |_| true).unwrap();
    near(found.dip_m.unwrap(), 9.6e-3, 5e-5, "dip");
    near(found.blow_m.unwrap(), 47.5e-3, 1e-4, "blow");
    let soft = softest(&bent, &mut |_| true).unwrap().unwrap();
    let soft = soft.flight.unwrap();
    near(soft.let_off_speed_m_per_s, soft.fall_speed_m_per_s, 0.02, "what the flight takes");
}

/// The ratios of the sheet's geometry, from the engine's own contacts, equal those of the linkage derived from the
/// levers' graph, solved by Newton's method: two derivations of one kinematics. Rounding of compressions over lever
/// arms and of residuals: 1e-9 is generous, and any wrong sign or contact fails by far.
#[test]
fn the_sheet_s_geometry_is_the_linkage_s() {
    for grand in both() {
        let levers = derive(&grand).unwrap().levers;
        let train = levers.assemble().unwrap();
        // Both from one pose: that in which the levers are placed.
        let drawn = RestPose::of(&grand, RestKind::AsDrawn, &mut |_| true).unwrap();
        let (parts, ratios) = on_the_scale(&drawn, 6e-3, [1e-3, 5e-3]).unwrap();
        let ratio =
            |key_m: f64| train.stroke(key_m, key_m, 0).poses[0].hammer_ratio * levers.head[0] / levers.key_front;
        for (ours, theirs, what) in [
            (ratios.at_rest, ratio(0.0), "at rest"),
            (ratios.half_way, ratio(3e-3), "half-way"),
            (ratios.at_let_off, ratio(6e-3), "at let-off"),
            (ratios.where_weighed, 0.5 * (ratio(1e-3) + ratio(5e-3)), "where weighed"),
            (parts.key_ratio, levers.contact_points(&train.rest())[0][0] / levers.key_front, "key ratio"),
        ] {
            near(ours, theirs, 1e-9 * theirs, what);
        }
    }
}
