//! A hammer's head alone, thrown at the strings of middle C: the simplest impact.

use erard::instrument::{Curve, Instrument, InstrumentFile};
use erard::mechanism::{Halving, Mechanism, Stepping, mechanism};
use moreau::Settings;

use super::super::ReproduceError;

/// At the end of an arm of a metre, touching the strings from below: three times the hammer of 2.97 g that strikes one
/// string in A. Chaigne and A. Askenfelt's C4.
const FILE: &str = r#"
format = "erard-instrument/1"
name = "A head of 8.9 g"
gravity_m_s2 = 0
[[body]]
name = "hammer"
pivot_mm = [0, 0]
mass_g = 8.9
inertia_kg_m2 = 8.9e-3
center_of_mass_mm = [1000, 0]
[[zone]]
name = "string"
[zone.disc]
body = "hammer"
center_mm = [1000, 0]
[zone.line]
body = "ground"
point_mm = [1000, 0]
normal = [0, -1]
[zone.felt]
stiffness_N_per_m_r = 1e10
exponent = 2.5
[roles]
hammer = "hammer"
hammer_head_mm = [1000, 0]
string = "string"
"#;

/// The head in front of a grand's strings, with the felt of its hammer, without dampers.
pub(crate) fn before(grand: &Instrument) -> Result<Instrument, ReproduceError> {
    let wrong = |text: String| ReproduceError::Instrument(text);
    let mut head = InstrumentFile::parse(FILE, "head").map_err(|error| wrong(error.to_string()))?.instrument;
    let zone = grand.roles.string.ok_or_else(|| wrong(format!("{} has no string", grand.name)))?;
    head.edit(|fields| {
        fields.zones[0].felt = grand.zones[zone].felt;
        fields.strings = grand.strings.clone();
        fields.strings.iter_mut().for_each(|string| string.damper = None);
    })
    .expect("numbers alone");
    Ok(head)
}

/// The head turned over, with a weight that keeps it on the strings.
pub(super) fn falling(grand: &Instrument, gravity_m_per_s2: f64) -> Result<Instrument, ReproduceError> {
    let mut head = before(grand)?;
    head.edit(|fields| {
        fields.gravity_m_per_s2 = gravity_m_per_s2;
        fields.zones[0].curve = Curve::Line { point_m: [1.0, 0.0], normal: [0.0, 1.0] };
    })
    .expect("numbers alone");
    Ok(head)
}

/// The head in flight, at the strings, with this upward speed, m/s.
pub(crate) fn thrown(head: &Instrument, step_s: f64, speed_m_per_s: f64) -> Result<Box<dyn Mechanism>, ReproduceError> {
    let settings = Settings { tolerance: 1e-10, ..Settings::new(step_s) };
    let mut thrown = mechanism(head, settings).map_err(|error| ReproduceError::Instrument(error.to_string()))?;
    // To show the scheme itself.
    thrown.configure(Stepping { halving: Halving::Never, ..*thrown.readout().stepping });
    let mut saved = thrown.save();
    saved.state.velocity[0] = speed_m_per_s;
    thrown.restore(&saved);
    Ok(thrown)
}
