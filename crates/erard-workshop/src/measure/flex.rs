//! Flexibility of key and shank, as technicians measure it on the bench: a weight on one end while the other is held.
//!
//! The key lies on its balance hole and its capstan, its back is held, and a kilogram is put on the playing end; the
//! shank is held at the stock of its knuckle, and a pound hangs 5 1/8 inches from its centre. For rigid pieces on
//! torsion springs the compliance is a sum over the bends,
//!
//! ```text
//! give / force = sum over bends of (x_load - x_bend)^2 / k
//! ```
//!
//! with x along the part. A part without bends gives 0.

use erard::instrument::{Instrument, Placement};

/// Place of the pound on the shank, m from the hammer's centre: 5 1/8 inches (J. Ellis, Caut mailing list, November
/// 2003).
pub(crate) const SHANK_LOAD_M: f64 = 0.1302;
/// Weight of a pound, N.
pub(crate) const POUND_N: f64 = 4.448;

/// Compliance of the key at its playing end with fulcrum and capstan held, m/N; `None` without a key.
#[must_use]
pub(crate) fn key_flex_m_per_n(instrument: &Instrument) -> Option<f64> {
    let roles = &instrument.roles;
    roles.key.and_then(|key| flex(instrument, key, |along| along.to_world(roles.key_front_m)[0]))
}

/// Compliance of the shank across its length at [`SHANK_LOAD_M`], held at the knuckle, m/N; `None` without a hammer.
#[must_use]
pub(crate) fn shank_flex_m_per_n(instrument: &Instrument) -> Option<f64> {
    instrument.roles.hammer.and_then(|hammer| flex(instrument, hammer, |_| SHANK_LOAD_M))
}

fn flex(instrument: &Instrument, piece: usize, load_m: impl Fn(&Placement) -> f64) -> Option<f64> {
    let load = load_m(&instrument.on_first_piece(piece).ok()?);
    let (mut give, mut body) = (0.0, piece);
    while instrument.bodies[body].is_bend {
        let own = instrument.springs.iter().filter(|spring| spring.body == body);
        let stiffness: f64 = own.map(|spring| spring.stiffness_n_m_per_rad).sum();
        let arm = load - instrument.on_first_piece(body).ok()?.pivot_m[0];
        give += arm * arm / stiffness;
        let Some(parent) = instrument.bodies[body].parent else { break };
        body = parent;
    }
    Some(give)
}

#[cfg(test)]
mod tests {
    use super::*;
    use erard::{Action, Input, Settings};

    /// A beam of two bends, its first piece held: the engine's equilibrium under a newton agrees with the sum.
    #[test]
    fn the_engine_gives_as_much() {
        let text = |held: &str| {
            format!(
                r#"
                format = "erard-instrument/1"
                name = "Two bends"
                gravity_m_s2 = 0
                finger = {{ stiffness_N_per_m = 2e4, damping_N_s_per_m = 1 }}
                roles = {{ key = "tip", key_front_mm = [-100, 0] }}
                {held}
                [[body]]
                name = "tip"
                hinged_on = "middle"
                bend = true
                pivot_mm = [-80, 0]
                mass_g = 20
                inertia_kg_m2 = 2e-4
                center_of_mass_mm = [-50, 0]
                viscous_N_m_s = 1.0
                [[spring]]
                name = "second"
                body = "tip"
                torque_N_m = 0
                stiffness_N_m_per_rad = 300
                [[spring]]
                name = "first"
                body = "middle"
                torque_N_m = 0
                stiffness_N_m_per_rad = 500
            "#
            )
        };
        let middle =
            "pivot_mm = [-10, 0]\nmass_g = 20\ninertia_kg_m2 = 2e-4\ncenter_of_mass_mm = [-50, 0]\nviscous_N_m_s = 1.0";
        let back = "[[body]]\nname = \"back\"\npivot_mm = [0, 0]\nmass_g = 20\ninertia_kg_m2 = 2e-4\ncenter_of_mass_mm = [0, 0]";
        let whole = text(&format!("{back}\n[[body]]\nname = \"middle\"\nhinged_on = \"back\"\nbend = true\n{middle}"));
        let whole = Instrument::parse(&whole, "whole").unwrap();
        // The bends are 10 and 90 mm from the pivot, the load 190 mm.
        let expected = 0.18 * 0.18 / 500.0 + 0.1 * 0.1 / 300.0;
        assert!((key_flex_m_per_n(&whole).unwrap() / expected - 1.0).abs() < 1e-12);

        let held = text(&format!("[[body]]\nname = \"middle\"\n{middle}"));
        let held = Instrument::parse(&held, "held").unwrap();
        let mut action = Action::as_drawn(&held, Settings::new(50e-6)).unwrap();
        let reading = (0..20_000).map(|_| action.step(Input::Force(1.0))).last().unwrap();
        assert!((reading.key_m / expected - 1.0).abs() < 1e-4, "{} {expected}", reading.key_m);
    }

    #[test]
    fn what_does_not_bend_gives_nothing() {
        let rigid = Instrument::builtin("concert-grand").unwrap().locked();
        assert_eq!([key_flex_m_per_n(&rigid), shank_flex_m_per_n(&rigid)], [Some(0.0); 2]);
    }
}
