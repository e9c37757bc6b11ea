//! Runs that must give the same bits on every target: here, and in the program that `crates/erard-core/tests/wasm/run`
//! compiles for WebAssembly.

use erard::instrument::Instrument;
use erard::keyboard::Keyboard;
use erard::level::{DURATION_S, HandKind, LEVELS, MASS_KG, Reference};
use erard::run::{Run, press_by_hand};
use erard::saved::{FNV1A, fnv1a};
use erard::stroke::{HandStroke, Touch};
use erard::{Setup, press};
use moreau::Settings;

use super::{Play, USUAL_STEP_S, grand, rigid_grand};

/// FNV-1a over the bits of all series that the mechanics produce, and of the ledger.
pub fn digest(run: &Run) -> u64 {
    let l = run.ledger.as_ref().expect("it is kept");
    let totals = [l.now.total(), l.drive_work, l.pivot_dry, l.pivot_viscous, l.felt_damping, l.coulomb];
    let angles = run.bodies.iter().flat_map(|b| b.angle_rad.iter().chain(&b.rate_rad_per_s));
    let forces = run.zones.iter().flat_map(|z| z.normal_n.iter().chain(&z.tangential_n));
    let numbers =
        angles.chain(forces).chain(&run.key_m).chain(&run.force_n).chain(&run.final_pivot_friction_n_m).chain(&totals);
    fnv1a(FNV1A, numbers.flat_map(|x| x.to_bits().to_le_bytes()))
}

/// Twelve notes of one second, soft to loud, one after the other: 240 000 steps.
fn notes(instrument: &Instrument, plays: impl Iterator<Item = Play>) -> u64 {
    plays.fold(0, |all, play| {
        let run = play.run_every(instrument, Settings::new(USUAL_STEP_S), 1.0, Some(100));
        all.rotate_left(5) ^ digest(&run)
    })
}

/// The rigid grand under the frozen strokes.
pub fn long_run() -> u64 {
    let plays = Play::frozen_strokes().chain([Play::ForceStep(12.0, 0.6), Play::FrozenRigid("mf", Touch::Pressed)]);
    notes(&rigid_grand(), plays)
}

/// The concert grand that bends, under the built-in strokes.
pub fn long_bending_run() -> u64 {
    let plays = Play::strokes().chain([Play::ForceStep(12.0, 0.6), Play::Rigid("mf", Touch::Pressed)]);
    notes(&grand(), plays)
}

/// The rigid grand under three hands, pressed, led and struck, that leave the key.
pub fn long_hand_run() -> u64 {
    let touches = [
        HandStroke::ramped(120.0).relaxing(0.1, 3.0).leaving(0.2, 0.03),
        HandStroke::led(0.15).leaving(0.3, 0.03),
        HandStroke::struck(0.1, 0.6).relaxing(0.05, 2.0).leaving(0.2, 0.03),
    ];
    touches.iter().fold(0, |all: u64, touch| {
        let setup = Setup { record_every: Some(100), hand: Some(touch.hand), ..Setup::new(0.5) };
        let run = press(&rigid_grand(), &|t| touch.input(t), &setup).expect("the rigid grand runs");
        let hand = run.ledger.as_ref().expect("it is kept").hand;
        let energies = [hand.muscle_work, hand.kinetic_gain, hand.fingertip_loss];
        all.rotate_left(5) ^ fnv1a(digest(&run), energies.iter().flat_map(|x| x.to_bits().to_le_bytes()))
    })
}

/// The built-in touches at pp, mf and ff, found on the grand that bends and played on it.
pub fn long_level_run() -> u64 {
    let grand = grand();
    let mut reference = Reference::new(&grand, &mut |_| true).expect("the concert grand plays");
    let touches = [Touch::Pressed, Touch::Struck].map(|touch| HandKind::new(touch, MASS_KG));
    let levels = touches.into_iter().flat_map(|kind| [0, 2, 4].map(|level| (kind, LEVELS[level].1)));
    levels.fold(0, |all: u64, (kind, speed_m_per_s)| {
        let found = reference.solve(kind, speed_m_per_s, &mut |_| true).expect("a level of the concert grand");
        let numbers = [found.louder, found.impact.time_s, found.impact.hammer_speed_m_per_s];
        let setup = Setup { record_every: Some(100), ..Setup::new(DURATION_S) };
        let run = press_by_hand(&grand, &found.whole(), &setup, &mut |_| true).expect("the concert grand runs");
        all.rotate_left(5) ^ fnv1a(digest(&run), numbers.iter().flat_map(|x| x.to_bits().to_le_bytes()))
    })
}

/// The digest of [`long_level_run`]. It changes with the engine, the concert grand, the hands and the search for their
/// levels.
pub const LEVELS_PLAYED: u64 = 0xac5d_4a7a_f348_fef6;

/// The digest of [`long_hand_run`]. It changes with every change to the arithmetic of the engine, of hands and of their
/// strokes, and to the rigid grand.
pub const HANDS: u64 = 0x13bc_252b_a380_a651;

/// The digest of [`long_bending_run`]. It changes with every change to the arithmetic of the engine, to the concert
/// grand and to the built-in strokes.
pub const BENDING: u64 = 0xa2f0_f54c_bbf5_dc0d;

/// The digest of [`long_run`]. It changes with every change to the arithmetic of the engine and to the rigid grand, and
/// with nothing else. When it is meant to change, look at the other tests' numbers first, then put the new value, which
/// the failing test prints, here.
pub const GOLDEN: u64 = 0x018d_4f2c_7fd6_4e6f;

/// The digest of all built-in instruments and of the built-in keyboard's keys as loaded: with [`GOLDEN`] it says on
/// which side of the loader a difference between two targets arises. It changes with every number of these instruments
/// that changes a step.
pub const LOADED: u64 = 0xeb6e_fa11_4fa0_d465;

/// The digest of everything that is built in, as loaded: of the instruments' own ([`erard::identity`]).
pub fn loaded() -> u64 {
    let keyboard = Keyboard::builtin("concert-grand").expect("built in");
    let builtin = Instrument::builtin_names().map(|name| Instrument::builtin(name).expect("built in"));
    let keys = [1, 40, 88].map(|key| keyboard.key(key).expect("a key"));
    builtin.chain(keys).fold(FNV1A, |hash, instrument| fnv1a(hash, instrument.digest().to_le_bytes()))
}
