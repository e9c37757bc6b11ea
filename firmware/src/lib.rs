//! The engine without the standard library: a key on its balance rail as a control loop would step it, in single precision.

#![no_std]

use moreau::{Body, Curve, Description, Exponent, Felt, GROUND, Input, Loss, Settings, Site, Spring, State, Workspace, Zone, step};

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}

/// Inertia of a whole action at the key, kg m2; its weight, N m; key front radius, m; dip, m.
const INERTIA: f32 = 0.025;
const WEIGHT: f32 = -0.106;
const FRONT: f32 = -0.265;
const DIP: f32 = 0.0096;

/// Steps a key for `steps` steps of `step_s` seconds under `force_n` newtons and returns how far its front has gone down, m;
/// not-a-number if the model cannot be assembled.
#[unsafe(no_mangle)]
pub extern "C" fn erard_key_travel(force_n: f32, step_s: f32, steps: u32) -> f32 {
    let felt = Felt { stiffness: 5e7, exponent: Exponent::Two, loss: Loss::Quadratic(1e8) };
    let stop = |x: f32, y: f32| Zone {
        disc_body: 0,
        center: [x, 0.0],
        radius: 0.0,
        curve_body: GROUND,
        curve: Curve::Line { point: [x, y], normal: [0.0, 1.0] },
        felt,
        friction: None,
    };
    let body = Body { inertia: INERTIA, dry: 0.0176, viscous: 5e-4, ..Body::inert() };
    let spring = Spring { body: 0, torque: WEIGHT, stiffness: 0.0, reference: 0.0 };
    let site = Site { body: 0, point: [FRONT, 0.0], direction: [0.0, -1.0], stiffness: 2e4, damping: 20.0 };
    let zones = [stop(FRONT, -DIP), stop(0.225, 0.0001)];
    let Ok(model) = Description { bodies: &[body], springs: &[spring], zones: &zones, dwells: &[], site: Some(site), gravity: 9.81 }.compile::<1, 2>() else {
        return f32::NAN;
    };
    let settings = Settings::new(step_s);
    let mut state = State::at_rest([0.0]);
    let mut workspace = Workspace::<f32, 1, 2, 2>::new();
    for _ in 0..steps {
        step(&model, &settings, &Input::Force(force_n), &mut state, &mut workspace);
    }
    model.site_position(&state.angle)
}
