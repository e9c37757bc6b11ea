//! A thousand poses of the piano's three levers, solved and with their leverage.
//!
//! The claim: well under a millisecond, on one core of an ordinary machine.

use divan::counter::ItemsCount;
use erard_kinematics::three_lever::{Drive, Regulation, ThreeLever};

fn main() {
    divan::main();
}

/// The whole stroke in a thousand poses, memory used again.
#[divan::bench]
fn a_thousand_poses(bencher: divan::Bencher) {
    let train = ThreeLever::c7f_like().assemble().unwrap();
    let mut poses = Vec::with_capacity(1000);
    bencher.counter(ItemsCount::new(1000_u32)).bench_local(|| {
        let stop = train.stroke_into(0.0, 0.008, 999, &mut poses);
        assert!(stop.is_none() && poses.len() == 1000);
        poses[999].leverage
    });
}

/// What is done once: graph, circuits, equations, rest pose.
#[divan::bench]
fn assembly(bencher: divan::Bencher) {
    let levers = ThreeLever::c7f_like();
    bencher.bench(|| levers.assemble().unwrap());
}

/// Deriving and printing the closure equations.
#[divan::bench]
fn equations(bencher: divan::Bencher) {
    let levers = ThreeLever::c7f_like();
    bencher.bench(|| {
        let mechanism = levers.linkage(Drive::Key).assemble().unwrap();
        mechanism.equations().iter().map(ToString::to_string).collect::<Vec<_>>()
    });
}

/// One what-if case: a move, regulation, and a stroke of a hundred poses.
#[divan::bench]
fn a_moved_case(bencher: divan::Bencher) {
    let levers = ThreeLever::c7f_like();
    bencher.bench(|| {
        let part = erard_kinematics::three_lever::Move::Knuckle(-0.003);
        let moved = levers.moved(&[part], Regulation::Regulated).unwrap();
        moved.assemble().unwrap().stroke(0.0, 0.006, 100)
    });
}
