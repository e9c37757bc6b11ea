//! Instrument file after a work list: the same text with other numbers.

use super::Worklist;
use erard::instrument::{FileNumber, Instrument, RewriteError, numbers_at, with_numbers};

const G: f64 = 1e3;
const MM: f64 = 1e3;

impl Worklist {
    /// Returns `text`, the file that `begun` was read from, with the numbers of the copy on which the list was carried
    /// out: screws, masses, friction, the capstan line.
    ///
    /// # Errors
    /// See [`RewriteError`].
    pub fn rewrite(&self, begun: &Instrument, text: &str) -> Result<String, RewriteError> {
        let turned = self.copy.rewrite(
            text,
            "Carried out in simulation: the list of erard measure --sheet",
            "as the list says",
        )?;
        let mut changes: Vec<(String, usize, f64)> = Vec::new();
        for (old, new) in begun.bodies.iter().zip(&self.copy.bodies) {
            let name = &new.name;
            let mut number = |number: FileNumber, component: usize, [old, new]: [f64; 2]| {
                if old != new {
                    changes.push((number.path(name), component, new));
                }
            };
            number(FileNumber::BODY_MASS, 0, [old.mass_kg, new.mass_kg].map(|kg| kg * G));
            number(FileNumber::BODY_INERTIA, 0, [old.inertia_kg_m2, new.inertia_kg_m2]);
            number(FileNumber::BODY_FRICTION, 0, [old.friction_torque_n_m, new.friction_torque_n_m]);
            for component in 0..2 {
                let place = [old, new].map(|body| body.center_of_mass_m[component] * MM);
                number(FileNumber::BODY_CENTER, component, place);
            }
        }
        // A zone's place in the file is the drawn one, from which the screws' settings are counted.
        let by_screws = |instrument: &Instrument| {
            let mut drawn = instrument.clone();
            for screw in 0..drawn.screws.len() {
                let _ = drawn.turn(screw, 0.0);
            }
            drawn
        };
        for (old, new) in by_screws(begun).zones.iter().zip(&by_screws(&self.copy).zones) {
            let by_mm = (new.disc_center_m[0] - old.disc_center_m[0]) * MM;
            let path = FileNumber::DISC_CENTER.path(&new.name);
            if by_mm.abs() > 1e-6 {
                let there = numbers_at(&turned, &path).ok_or_else(|| RewriteError::NoNumber(path.clone()))?;
                changes.push((path, 0, there[0] + by_mm));
            }
        }
        let written: Vec<(&str, usize, f64)> = changes
            .iter()
            .map(|(path, component, value)| (path.as_str(), *component, erard::parameter::ten_digits(*value)))
            .collect();
        with_numbers(&turned, &written).ok_or_else(|| {
            RewriteError::NoNumber(written.first().map_or(String::new(), |(path, ..)| (*path).to_owned()))
        })
    }
}
