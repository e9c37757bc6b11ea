//! The built-in instrument `concert-grand`. Written by `.ci/regenerate firmware`: do not edit.

use moreau::{Body, ContactCurve, Exponent, Felt, GROUND, Iwan, Loss, Scalar, Site, Spring, Zone};

pub const BODIES: usize = 9;
pub(crate) const SPRINGS: usize = 4;
pub const ZONES: usize = 18;
/// Room for the set-valued laws.
pub(crate) const LAWS: usize = 15;
pub(crate) const GRAVITY: f64 = 9.81;
/// Where it rests, friction included, rad.
pub(crate) const REST: [f64; BODIES] = [1.350798993224904e-6, 4.8335950695816556e-5, 0.00018573921387292995, 0.0013355539587471834, 0.00024625921343807817, -0.0030079617055844173, -0.3477219084641573, -0.3481043816390729, 0.0026703940101332315];
/// The body that strikes, and its point that meets the string, m in its frame.
pub(crate) const HAMMER: usize = 7;
pub(crate) const HAMMER_POINT: [f64; 2] = [0.07, 0.048];
/// The zone of hammer and string.
pub(crate) const STRING: usize = 10;
/// Travel of the key at which it sets its damper down, m.
pub(crate) const DAMPER_M: f64 = 0.005067750000299822;

#[rustfmt::skip]
pub(crate) fn bodies<T: Scalar>() -> [Body<T>; BODIES] {
    let t = T::from_f64;
    [
        Body { parent: GROUND, pivot: [t(-1.0), t(0.0)], mass: t(0.001), inertia: t(0.001), center_of_mass: [t(1.0), t(0.0)], dry: t(0.3), viscous: t(0.0) },
        Body { parent: 0, pivot: [t(1.0), t(0.0)], mass: t(0.054020000000000006), inertia: t(0.001273), center_of_mass: [t(0.13648), t(0.01)], dry: t(0.0065), viscous: t(0.0002) },
        Body { parent: 1, pivot: [t(0.0), t(0.0)], mass: t(0.08898), inertia: t(0.0025726), center_of_mass: [t(-0.15747), t(0.01)], dry: t(0.002), viscous: t(0.063) },
        Body { parent: GROUND, pivot: [t(0.20523), t(0.0445)], mass: t(0.011), inertia: t(3.7e-5), center_of_mass: [t(-0.05), t(0.01)], dry: t(0.000617), viscous: t(8e-6) },
        Body { parent: 3, pivot: [t(-0.085), t(0.002)], mass: t(0.004), inertia: t(3e-6), center_of_mass: [t(0.0), t(0.02)], dry: t(0.00025), viscous: t(1e-6) },
        Body { parent: 3, pivot: [t(-0.042), t(0.03)], mass: t(0.005), inertia: t(6.2e-6), center_of_mass: [t(-0.023), t(0.005)], dry: t(0.0012), viscous: t(1e-6) },
        Body { parent: GROUND, pivot: [t(0.11243), t(0.10809999999999999)], mass: t(0.0024820000000000003), inertia: t(2.011e-6), center_of_mass: [t(0.023440000000000003), t(0.0)], dry: t(0.00079), viscous: t(2e-6) },
        Body { parent: 6, pivot: [t(0.06), t(0.0)], mass: t(0.008718), inertia: t(4.0611e-5), center_of_mass: [t(0.06308), t(0.01445)], dry: t(0.0002), viscous: t(0.00072) },
        Body { parent: GROUND, pivot: [t(0.3), t(0.04)], mass: t(0.034), inertia: t(5e-5), center_of_mass: [t(-0.036), t(0.0)], dry: t(0.001), viscous: t(8e-6) },
    ]
}

#[rustfmt::skip]
pub(crate) fn springs<T: Scalar>() -> [Spring<T>; SPRINGS] {
    let t = T::from_f64;
    [
        Spring { body: 2, torque: t(0.0), stiffness: t(1000.0), reference: t(0.0) },
        Spring { body: 7, torque: t(0.0), stiffness: t(14.06), reference: t(0.0) },
        Spring { body: 5, torque: t(-0.029828999999999998), stiffness: t(0.08), reference: t(0.0) },
        Spring { body: 4, torque: t(-0.0045), stiffness: t(0.01), reference: t(0.0) },
    ]
}

#[rustfmt::skip]
pub(crate) fn zones<T: Scalar>() -> [Zone<T>; ZONES] {
    let t = T::from_f64;
    [
        Zone { disc_body: 2, center: [t(-0.265), t(0.0)], radius: t(0.0), curve_body: GROUND, curve: ContactCurve::Line { point: [t(-0.265), t(-0.009357299999999999)], normal: [t(0.0), t(1.0)] }, felt: Felt { stiffness: t(2000000000.0), exponent: Exponent::TwoAndHalf, loss: Loss::Iwan(Iwan { damping: t(260000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
        Zone { disc_body: 1, center: [t(0.0), t(0.0)], radius: t(0.0), curve_body: GROUND, curve: ContactCurve::Line { point: [t(0.0), t(3.9e-5)], normal: [t(0.0), t(1.0)] }, felt: Felt { stiffness: t(1330000000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(260000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
        Zone { disc_body: 1, center: [t(0.225), t(-0.005)], radius: t(0.0), curve_body: GROUND, curve: ContactCurve::Line { point: [t(0.225), t(-0.004900000000000001)], normal: [t(0.0), t(1.0)] }, felt: Felt { stiffness: t(33300000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(100000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
        Zone { disc_body: 1, center: [t(0.14223), t(0.018348899999999998)], radius: t(0.01), curve_body: 3, curve: ContactCurve::Line { point: [t(-0.063), t(-0.01618)], normal: [t(0.0), t(-1.0)] }, felt: Felt { stiffness: t(47700000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(220000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: Some(t(0.25)) },
        Zone { disc_body: 6, center: [t(0.017), t(-0.0048)], radius: t(0.005), curve_body: 4, curve: ContactCurve::Segment { from: [t(0.0), t(0.04537)], direction: [t(1.0), t(0.0)], length: t(0.0070999999999999995), rounding: t(0.001) }, felt: Felt { stiffness: t(30300000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(140000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: Some(t(0.25)) },
        Zone { disc_body: 6, center: [t(0.017), t(-0.0048)], radius: t(0.005), curve_body: 5, curve: ContactCurve::Line { point: [t(-0.037), t(0.01837)], normal: [t(0.0), t(1.0)] }, felt: Felt { stiffness: t(30300000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(140000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: Some(t(0.15)) },
        Zone { disc_body: 4, center: [t(-0.024), t(0.004)], radius: t(0.0), curve_body: GROUND, curve: ContactCurve::Line { point: [t(0.09623000000000001), t(0.0556938)], normal: [t(0.0), t(-1.0)] }, felt: Felt { stiffness: t(66700000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(200000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: Some(t(0.3)) },
        Zone { disc_body: 4, center: [t(0.005), t(0.028)], radius: t(0.0), curve_body: 3, curve: ContactCurve::Line { point: [t(-0.0800165), t(0.03)], normal: [t(-1.0), t(0.0)] }, felt: Felt { stiffness: t(66700000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(200000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
        Zone { disc_body: 5, center: [t(0.02), t(-0.003)], radius: t(0.0), curve_body: 3, curve: ContactCurve::Line { point: [t(-0.022), t(0.026973999999999998)], normal: [t(0.0), t(1.0)] }, felt: Felt { stiffness: t(66700000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(200000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
        Zone { disc_body: 5, center: [t(-0.054), t(0.022)], radius: t(0.0), curve_body: GROUND, curve: ContactCurve::Line { point: [t(0.10923000000000001), t(0.1024118)], normal: [t(0.0), t(-1.0)] }, felt: Felt { stiffness: t(66700000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(200000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
        Zone { disc_body: 7, center: [t(0.07), t(0.048)], radius: t(0.0), curve_body: GROUND, curve: ContactCurve::Line { point: [t(0.251), t(0.1555)], normal: [t(0.0), t(-1.0)] }, felt: Felt { stiffness: t(1500000000.0), exponent: Exponent::TwoAndHalf, loss: Loss::quadratic(t(50000000.0)) }, friction: None },
        Zone { disc_body: 7, center: [t(0.073), t(-0.015)], radius: t(0.004), curve_body: 1, curve: ContactCurve::Line { point: [t(0.24907899999999997), t(0.0686)], normal: [t(-0.939699957713503), t(0.34199998461000114)] }, felt: Felt { stiffness: t(33300000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(200000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: Some(t(0.5)) },
        Zone { disc_body: 7, center: [t(0.03), t(-0.003)], radius: t(0.0), curve_body: 3, curve: ContactCurve::Line { point: [t(-0.00893), t(0.02682)], normal: [t(0.0), t(1.0)] }, felt: Felt { stiffness: t(66700000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(200000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
        Zone { disc_body: 8, center: [t(-0.065), t(-0.018)], radius: t(0.0), curve_body: 1, curve: ContactCurve::Line { point: [t(0.235), t(0.0176)], normal: [t(0.0), t(1.0)] }, felt: Felt { stiffness: t(33300000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(100000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
        Zone { disc_body: 8, center: [t(-0.045), t(0.0)], radius: t(0.0), curve_body: GROUND, curve: ContactCurve::Line { point: [t(0.255), t(0.04)], normal: [t(0.0), t(1.0)] }, felt: Felt { stiffness: t(20000000.0), exponent: Exponent::Two, loss: Loss::quadratic(t(80000000.0)) }, friction: None },
        Zone { disc_body: 8, center: [t(-0.045), t(0.007)], radius: t(0.0), curve_body: GROUND, curve: ContactCurve::Line { point: [t(0.255), t(0.0519)], normal: [t(0.0), t(-1.0)] }, felt: Felt { stiffness: t(33300000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(300000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
        Zone { disc_body: 4, center: [t(-0.005), t(0.028)], radius: t(0.0), curve_body: 3, curve: ContactCurve::Line { point: [t(-0.09570999999999999), t(0.02835)], normal: [t(0.9781480483031462), t(0.2079095851584186)] }, felt: Felt { stiffness: t(66700000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(400000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
        Zone { disc_body: 1, center: [t(0.0), t(0.0)], radius: t(0.0), curve_body: GROUND, curve: ContactCurve::Line { point: [t(0.0), t(0.0)], normal: [t(0.0), t(-1.0)] }, felt: Felt { stiffness: t(1330000000.0), exponent: Exponent::Two, loss: Loss::Iwan(Iwan { damping: t(260000000.0), eta: t(0.5), slip: t(0.1) }) }, friction: None },
    ]
}

#[rustfmt::skip]
pub(crate) fn site<T: Scalar>() -> Site<T> {
    let t = T::from_f64;
    Site { body: 2, point: [t(-0.265), t(0.022)], direction: [t(0.0), t(-1.0)], stiffness: t(20000.0), damping: t(20.0) }
}
