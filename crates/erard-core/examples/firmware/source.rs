//! An instrument as Rust source: the engine's description, every number in the shortest digits that read back as the
//! same, and where it rests.

use std::fmt::Write;

use erard_core::assembly::describe;
use erard_core::damper::damper_height_m;
use erard_core::{Action, Instrument};
use moreau::{Body, ContactCurve, Exponent, Felt, GROUND, Loss, Site, Spring, Zone};

/// The built-in concert grand, its key held as in `erard live`: a sensor gives where the key is.
pub fn instrument() -> Instrument {
    Instrument::builtin("concert-grand").expect("built in").with_held_key()
}

/// Its source.
pub fn grand() -> String {
    source("concert-grand", &instrument())
}

fn source(name: &str, instrument: &Instrument) -> String {
    let mechanism = describe::<f64>(instrument);
    let rest = Action::new(instrument).expect("it comes to rest");
    let mut out = format!(
        "//! The built-in instrument `{name}`. Written by `.ci/regenerate firmware`: do not edit.\n\n\
         use moreau::{{Body, ContactCurve, Exponent, Felt, GROUND, Iwan, Loss, Scalar, Site, Spring, Zone}};\n\n\
         pub const BODIES: usize = {};\npub(crate) const SPRINGS: usize = {};\npub const ZONES: usize = {};\n\
         /// Room for the set-valued laws.\npub(crate) const LAWS: usize = {};\n\
         pub(crate) const GRAVITY: f64 = {:?};\n/// Where it rests, friction included, rad.\npub(crate) const REST: [f64; BODIES] = {:?};\n\
         /// The body that strikes, and its point that meets the string, m in its frame.\npub(crate) const HAMMER: usize = {};\n\
         pub(crate) const HAMMER_POINT: [f64; 2] = {:?};\n/// The zone of hammer and string.\n\
         pub(crate) const STRING: usize = {};\n/// Travel of the key at which it sets its damper down, m.\n\
         pub(crate) const DAMPER_M: f64 = {:?};\n",
        mechanism.bodies.len(),
        mechanism.springs.len(),
        mechanism.zones.len(),
        mechanism.borrowed().laws(),
        mechanism.gravity,
        rest.angles(),
        instrument.roles.hammer.expect("a hammer"),
        instrument.roles.hammer_strike_point_m,
        instrument.roles.string.expect("a string"),
        damper_height_m(instrument).expect("a grand").expect("a damper"),
    );
    list(&mut out, "bodies", "Body", "BODIES", mechanism.bodies.iter().map(body));
    list(&mut out, "springs", "Spring", "SPRINGS", mechanism.springs.iter().map(spring));
    list(&mut out, "zones", "Zone", "ZONES", mechanism.zones.iter().map(zone));
    let site = site(&mechanism.site.expect("a key"));
    let _ = write!(
        out,
        "\n#[rustfmt::skip]\npub(crate) fn site<T: Scalar>() -> Site<T> {{\n    let t = T::from_f64;\n    {site}\n}}\n"
    );
    out
}

fn list(out: &mut String, name: &str, kind: &str, count: &str, items: impl Iterator<Item = String>) {
    let _ = write!(
        out,
        "\n#[rustfmt::skip]\npub(crate) fn {name}<T: Scalar>() -> [{kind}<T>; {count}] {{\n    let t = T::from_f64;\n    [\n"
    );
    for item in items {
        let _ = writeln!(out, "        {item},");
    }
    out.push_str("    ]\n}\n");
}

fn t(x: f64) -> String {
    format!("t({x:?})")
}

fn v([x, y]: [f64; 2]) -> String {
    format!("[{}, {}]", t(x), t(y))
}

fn index(body: usize) -> String {
    if body == GROUND { "GROUND".into() } else { body.to_string() }
}

fn body(b: &Body<f64>) -> String {
    let Body { parent, pivot, mass, inertia, center_of_mass, dry, viscous } = *b;
    format!(
        "Body {{ parent: {}, pivot: {}, mass: {}, inertia: {}, center_of_mass: {}, dry: {}, viscous: {} }}",
        index(parent),
        v(pivot),
        t(mass),
        t(inertia),
        v(center_of_mass),
        t(dry),
        t(viscous)
    )
}

fn spring(s: &Spring<f64>) -> String {
    let Spring { body, torque, stiffness, reference } = *s;
    format!(
        "Spring {{ body: {body}, torque: {}, stiffness: {}, reference: {} }}",
        t(torque),
        t(stiffness),
        t(reference)
    )
}

fn zone(z: &Zone<f64>) -> String {
    let Zone { disc_body, center, radius, curve_body, curve, felt, friction } = *z;
    format!(
        "Zone {{ disc_body: {}, center: {}, radius: {}, curve_body: {}, curve: {}, felt: {}, friction: {} }}",
        index(disc_body),
        v(center),
        t(radius),
        index(curve_body),
        self::curve(&curve),
        self::felt(&felt),
        friction.map_or("None".into(), |mu| format!("Some({})", t(mu)))
    )
}

fn curve(c: &ContactCurve<f64>) -> String {
    match *c {
        ContactCurve::Line { point, normal } => {
            format!("ContactCurve::Line {{ point: {}, normal: {} }}", v(point), v(normal))
        }
        ContactCurve::Segment { from, direction, length, rounding } => format!(
            "ContactCurve::Segment {{ from: {}, direction: {}, length: {}, rounding: {} }}",
            v(from),
            v(direction),
            t(length),
            t(rounding)
        ),
        ContactCurve::Disc { center, radius } => {
            format!("ContactCurve::Disc {{ center: {}, radius: {} }}", v(center), t(radius))
        }
    }
}

fn felt(f: &Felt<f64>) -> String {
    let Felt { stiffness, exponent, loss } = *f;
    let exponent = match exponent {
        Exponent::Two => "Exponent::Two".to_owned(),
        Exponent::TwoAndHalf => "Exponent::TwoAndHalf".to_owned(),
        Exponent::Three => "Exponent::Three".to_owned(),
        Exponent::Other(r) => format!("Exponent::Other({})", t(r)),
    };
    let loss = match loss {
        Loss::Quadratic(law) => format!("Loss::quadratic({})", t(law.damping)),
        Loss::HuntCrossley(law) => format!("Loss::hunt_crossley({})", t(law.rate)),
        Loss::Iwan(law) => {
            let [damping, eta, slip] = [law.damping, law.eta, law.slip].map(t);
            format!("Loss::Iwan(Iwan {{ damping: {damping}, eta: {eta}, slip: {slip} }})")
        }
        other => panic!("no source is written for this loss yet: {other:?}"),
    };
    format!("Felt {{ stiffness: {}, exponent: {exponent}, loss: {loss} }}", t(stiffness))
}

fn site(s: &Site<f64>) -> String {
    let Site { body, point, direction, stiffness, damping } = *s;
    format!(
        "Site {{ body: {body}, point: {}, direction: {}, stiffness: {}, damping: {} }}",
        v(point),
        v(direction),
        t(stiffness),
        t(damping)
    )
}
