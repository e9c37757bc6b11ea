//! The indices of an instrument: checked when it is made and when it is changed.

use thiserror::Error;

use super::{Instrument, InstrumentFields, ScrewAction};

/// An index of an instrument is out of range.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("`{field}` is {found}; expected {expected}")]
#[non_exhaustive]
pub struct InvalidInstrument {
    /// The field with the index, e.g. `springs[0].body`.
    pub field: String,
    /// The index found.
    pub found: usize,
    /// What is allowed, e.g. `a body, 0 to 6`.
    pub expected: String,
}

impl Instrument {
    /// Makes an instrument of its fields.
    ///
    /// # Errors
    /// [`InvalidInstrument`]: an index is out of range.
    pub fn new(fields: InstrumentFields) -> Result<Self, InvalidInstrument> {
        check(&fields)?;
        Ok(Instrument { fields })
    }

    /// Changes the instrument. `change` gets its fields, and returns whatever the caller needs.
    ///
    /// ```
    /// # let mut grand = erard_core::Instrument::builtin("concert-grand").unwrap();
    /// grand.edit(|fields| fields.bodies[0].mass_kg *= 1.1).unwrap();
    /// assert!(grand.edit(|fields| fields.springs[0].body = 99).is_err());
    /// ```
    ///
    /// # Errors
    /// [`InvalidInstrument`]: after the change an index is out of range. The instrument is then as it was.
    pub fn edit<R>(&mut self, change: impl FnOnce(&mut InstrumentFields) -> R) -> Result<R, InvalidInstrument> {
        let mut fields = self.fields.clone();
        let returned = change(&mut fields);
        check(&fields)?;
        self.fields = fields;
        Ok(returned)
    }

    /// Changes the name.
    pub fn rename(&mut self, name: &str) {
        name.clone_into(&mut self.fields.name);
    }

    /// The instrument without outlines for drawing, which take no part in the mechanics.
    #[must_use]
    pub fn without_outlines(mut self) -> Self {
        self.fields.parts = Vec::new();
        self
    }
}

/// Checks every index.
fn check(fields: &InstrumentFields) -> Result<(), InvalidInstrument> {
    let InstrumentFields { bodies, springs, zones, strings, roles, screws, parts, .. } = fields;
    let below = |index: usize, count: usize, what: &str, field: &dyn Fn() -> String| {
        if index < count {
            return Ok(());
        }
        let expected = match count {
            0 => format!("none, for there is no {what}"),
            count => format!("a {what}, 0 to {}", count - 1),
        };
        Err(InvalidInstrument { field: field(), found: index, expected })
    };
    let body = |index: usize, field: &dyn Fn() -> String| below(index, bodies.len(), "body", field);
    let zone = |index: usize, field: &dyn Fn() -> String| below(index, zones.len(), "zone", field);
    for (i, one) in bodies.iter().enumerate() {
        if let Some(parent) = one.parent {
            below(parent, i, "body that precedes it", &|| format!("bodies[{i}].parent"))?;
        }
    }
    for (i, spring) in springs.iter().enumerate() {
        body(spring.body, &|| format!("springs[{i}].body"))?;
    }
    for (i, one) in zones.iter().enumerate() {
        one.disc_body.map_or(Ok(()), |index| body(index, &|| format!("zones[{i}].disc_body")))?;
        one.curve_body.map_or(Ok(()), |index| body(index, &|| format!("zones[{i}].curve_body")))?;
    }
    for (i, string) in strings.iter().enumerate() {
        string.damper.map_or(Ok(()), |damper| zone(damper.zone, &|| format!("strings[{i}].damper.zone")))?;
    }
    for (i, screw) in screws.iter().enumerate() {
        match screw.action {
            ScrewAction::Disc { zone: index, .. }
            | ScrewAction::Curve { zone: index, .. }
            | ScrewAction::Turn { zone: index } => zone(index, &|| format!("screws[{i}].action.zone"))?,
            ScrewAction::Spring { spring } => {
                below(spring, springs.len(), "spring", &|| format!("screws[{i}].action.spring"))?;
            }
        }
    }
    for (i, part) in parts.iter().enumerate() {
        part.body.map_or(Ok(()), |index| body(index, &|| format!("parts[{i}].body")))?;
    }
    for (name, index) in [("key", roles.key), ("hammer", roles.hammer)] {
        index.map_or(Ok(()), |index| body(index, &|| format!("roles.{name}")))?;
    }
    let single = [
        ("key_bottom", roles.key_bottom),
        ("string", roles.string),
        ("pedal", roles.pedal),
        ("let_off", roles.let_off),
        ("check", roles.check),
    ];
    for (name, index) in single {
        index.map_or(Ok(()), |index| zone(index, &|| format!("roles.{name}")))?;
    }
    for (name, all) in [("knuckle", &roles.knuckle), ("transmits", &roles.transmits), ("stops", &roles.stops)] {
        for (i, index) in all.iter().enumerate() {
            zone(*index, &|| format!("roles.{name}[{i}]"))?;
        }
    }
    Ok(())
}
