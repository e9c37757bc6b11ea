//! Checks an instrument file and converts it to the instrument in SI units.

use std::ops::Range;

use super::error::Fault;
use super::felt::read_felt;
use super::file_number::FileNumber;
use super::format::{
    BodyToml, DiscToml, FORMAT, InstrumentToml, OneDofToml, PartToml, RolesToml, ScrewSide, ScrewToml, SpringToml,
    ZoneToml,
};
use super::quantity::{At, KeyName, Num, Pair, Positive, Real};
use super::reader::{G_PER_KG, GROUND, MM_PER_M, ReadNumber, Reader, body_or_ground, index_of, new_name, title};
use super::strings::{read_board, read_bridge, read_strings};
use super::{
    Body, Bushing, Curve, DrawnPart, Dwell, Finger, Instrument, InstrumentFields, MAX_BODIES, MAX_CORNERS, MAX_PARTS,
    MAX_SCREWS, MAX_SPRINGS, MAX_ZONES, Origin, Roles, Screw, ScrewAction, Spring, Vec2, Zone,
};
use crate::files::format_fault;
use crate::key::{EXPECTED, key_named};

/// Relative amount by which an inertia may be below that of a point mass at the centre of mass; it allows for rounded
/// decimals only.
const PARALLEL_AXIS_TOLERANCE: f64 = 1e-9;

/// Checks and converts a file.
pub(crate) fn convert(file: &InstrumentToml) -> Result<(Instrument, Vec<ReadNumber>), Fault> {
    if file.format.as_str() != FORMAT {
        let fault = format_fault(file.format.as_str(), FORMAT);
        return Err(Fault::at(file.format.span(), fault, format!("\"{FORMAT}\"")));
    }
    at_most(&file.body, MAX_BODIES, "bodies")?;
    at_most(&file.spring, MAX_SPRINGS, "springs")?;
    at_most(&file.zone, MAX_ZONES, "zones")?;
    at_most(&file.screw, MAX_SCREWS, "screws")?;
    at_most(&file.part, MAX_PARTS, "parts")?;

    let mut reader = Reader::new(&file.sources);
    let fields = InstrumentFields {
        name: title(&file.name, "an instrument")?,
        gravity_m_per_s2: reader.scalar(&file.gravity_m_per_s2, FileNumber::GRAVITY)?,
        bodies: Vec::new(),
        springs: Vec::new(),
        zones: Vec::new(),
        strings: Vec::new(),
        bridge_modes: Vec::new(),
        roles: Roles::default(),
        finger: Finger::default(),
        screws: Vec::new(),
        parts: Vec::new(),
        origin: Origin {
            key: file.key.as_ref().map(key_number).transpose()?,
            sample: file.sample.as_ref().map(sample_number).transpose()?,
        },
    };
    let mut instrument = Instrument { fields };
    read_bodies(&file.body, &mut reader, &mut instrument)?;
    for spring in &file.spring {
        let spring = read_spring(spring, &mut reader, &instrument)?;
        instrument.fields.springs.push(spring);
    }
    check_bends(&file.body, &instrument)?;
    for zone in &file.zone {
        let zone = read_zone(zone, &mut reader, &instrument)?;
        instrument.fields.zones.push(zone);
    }
    if let Some(roles) = &file.roles {
        instrument.fields.roles = read_roles(roles, &mut reader, &instrument)?;
    }
    let pedal = file.roles.as_ref().and_then(|roles| roles.pedal.as_ref());
    read_strings(&file.string, pedal, &mut reader, &mut instrument)?;
    read_bridge(&file.bridge_mode, &mut reader, &mut instrument)?;
    read_board(&file.board, &mut reader, &mut instrument)?;
    if let Some(one_dof) = &file.one_dof {
        read_one_dof(one_dof, &mut instrument)?;
    }
    match (&file.finger, &file.roles) {
        (Some(finger), _) => {
            instrument.fields.finger = Finger {
                stiffness_n_per_m: reader.scalar(&finger.stiffness_n_per_m, FileNumber::FINGER_STIFFNESS)?,
                damping_n_s_per_m: reader.scalar(&finger.damping_n_s_per_m, FileNumber::FINGER_DAMPING)?,
            }
        }
        (None, roles) => {
            if let Some(key) = roles.as_ref().and_then(|roles| roles.key.as_ref()) {
                return Err(Fault::at(key.span(), "there is a key but no [finger] to press it", "a table [finger]"));
            }
        }
    }
    for screw in &file.screw {
        let screw = read_screw(screw, &mut reader, &mut instrument)?;
        instrument.fields.screws.push(screw);
    }
    for part in &file.part {
        let part = read_part(part, &mut reader, &instrument)?;
        instrument.fields.parts.push(part);
    }
    read_bushings(&file.body, &mut reader, &mut instrument)?;
    Ok((instrument, reader.numbers))
}

/// Reads the number of a key.
pub(crate) fn key_number(key: &At<KeyName>) -> Result<usize, Fault> {
    key_named(&key.0).ok_or_else(|| Fault::at(key.span(), "not a key of a piano", EXPECTED))
}

fn sample_number(sample: &At<i64>) -> Result<u32, Fault> {
    u32::try_from(**sample)
        .ok()
        .filter(|sample| *sample >= 1)
        .ok_or_else(|| Fault::at(sample.span(), "not the number of a sample", "a whole number from 1"))
}

fn at_most<T>(tables: &[At<T>], most: usize, what: &str) -> Result<(), Fault> {
    match tables.get(most) {
        None => Ok(()),
        Some(table) => Err(Fault::at(table.span(), format!("too many {what}"), format!("at most {most} {what}"))
            .found(format!("{} {what}", tables.len()))),
    }
}

/// Reads the bodies and puts parents first, whatever their order in the file.
fn read_bodies(tables: &[At<BodyToml>], reader: &mut Reader<'_>, instrument: &mut Instrument) -> Result<(), Fault> {
    let mut names: Vec<String> = Vec::new();
    for table in tables {
        if table.name.as_str() == GROUND {
            return Err(Fault::at(table.name.span(), "`ground` is the world, not a body", "another name"));
        }
        let name = new_name(&table.name, "body", names.iter().map(String::as_str))?;
        names.push(name);
    }
    // Parents as indices into the file's list.
    let mut parents = Vec::new();
    for table in tables {
        parents.push(match &table.hinged_on {
            None => None,
            Some(parent) if parent.as_str() == GROUND => None,
            Some(parent) => Some(index_of(parent, "body", names.iter().map(String::as_str))?),
        });
    }
    let order = parents_first(&parents).map_err(|in_cycle| {
        let span = tables[in_cycle].hinged_on.as_ref().map_or(0..0, At::span);
        Fault::at(span, "these bodies are hinged on each other in a circle", "hinges that end at `ground`")
    })?;
    let mut place = vec![0; tables.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old] = new;
    }
    for &index in &order {
        let (table, parent) = (&tables[index], parents[index].map(|parent| place[parent]));
        instrument.fields.bodies.push(read_body(table, &names[index], parent, reader)?);
    }
    Ok(())
}

/// Adds the bushings. It shifts the indices of bodies, so everything that names bodies must have been read before.
fn read_bushings(tables: &[At<BodyToml>], reader: &mut Reader<'_>, instrument: &mut Instrument) -> Result<(), Fault> {
    for table in tables {
        let Some((bushing, span)) = read_bushing(table, reader)? else { continue };
        let body = index_of(&table.name, "body", instrument.bodies.iter().map(|body| body.name.as_str()))?;
        if instrument.bodies[body].is_bend {
            let expected = "a bushing on the piece that has the part's own pivot";
            return Err(Fault::at(span, "a bend has no pin for a bushing", expected));
        }
        if matches!(bushing, Bushing::Pin { .. }) && instrument.lies_on(body).is_none() {
            let on = instrument.bodies[body].parent.map_or(GROUND, |parent| &instrument.bodies[parent].name);
            let expected =
                format!("a [[zone]] whose disc is on `{}` at its pivot, [0, 0], and its line on `{on}`", *table.name);
            return Err(Fault::at(span, "nothing holds this pivot along its pin", expected));
        }
        let name = instrument.bushing_name(body, bushing);
        let taken = instrument.bodies.iter().map(|b| &b.name).chain(instrument.springs.iter().map(|s| &s.name));
        if taken.into_iter().any(|other| *other == name) {
            let message = format!("`{name}` is taken: the reader gives this bushing that name");
            return Err(Fault::at(span, message, "another name for that one"));
        }
        let needs_spring = matches!(bushing, Bushing::Cloth { .. });
        if instrument.bodies.len() >= MAX_BODIES || (needs_spring && instrument.springs.len() >= MAX_SPRINGS) {
            let expected = format!("at most {MAX_BODIES} bodies and {MAX_SPRINGS} springs, one of each per bushing");
            return Err(Fault::at(span, "there is no room for a bushing", expected));
        }
        *instrument = instrument.with_bushing_at(body, bushing);
    }
    Ok(())
}

/// Reads the bushing of a body, and the place of the key that asks for it.
fn read_bushing(table: &BodyToml, reader: &mut Reader<'_>) -> Result<Option<(Bushing, Range<usize>)>, Fault> {
    match (&table.bushing_n_per_m, &table.bushing_n_s_per_m, &table.pin_friction_n) {
        (None, None, None) => Ok(None),
        (None, Some(damping), _) => {
            let message = "this key needs another one";
            Err(Fault::at(damping.span(), message, "`bushing_N_per_m` beside it"))
        }
        (Some(_), _, Some(friction)) => {
            let expected = "either `bushing_N_per_m` or `pin_friction_N`";
            Err(Fault::at(friction.span(), "a pivot has one bushing", expected).found("both"))
        }
        (None, None, Some(friction)) => {
            let friction_n = reader.scalar(friction, FileNumber::PIN_FRICTION)?;
            Ok(Some((Bushing::Pin { friction_n }, friction.span())))
        }
        (Some(stiffness), damping, None) => {
            let n_per_m = reader.scalar(stiffness, FileNumber::BUSHING_STIFFNESS)?;
            let n_s_per_m = reader.scalar_or_zero(damping.as_ref(), FileNumber::BUSHING_DAMPING)?;
            Ok(Some((Bushing::Cloth { n_per_m, n_s_per_m }, stiffness.span())))
        }
    }
}

/// Reads the two keys of friction that grows at rest. They must be given together, and only beside a friction greater
/// than 0.
fn read_dwell(
    ratio: Option<&Num<Positive>>,
    time: Option<&Num<Positive>>,
    friction: f64,
    [ratio_of, time_of]: [FileNumber; 2],
    reader: &mut Reader<'_>,
) -> Result<Option<Dwell>, Fault> {
    match (ratio, time) {
        (None, None) => Ok(None),
        (Some(ratio), Some(time)) if friction > 0.0 => {
            Ok(Some(Dwell { ratio: reader.scalar(ratio, ratio_of)?, time_s: reader.scalar(time, time_of)? }))
        }
        (Some(ratio), Some(_)) => {
            Err(Fault::at(ratio.span(), "`static_friction_ratio` needs dry friction", "a friction greater than 0"))
        }
        (Some(one), None) => Err(Fault::at(one.span(), "this key needs another one", "`dwell_s` beside it")),
        (None, Some(one)) => {
            Err(Fault::at(one.span(), "this key needs another one", "`static_friction_ratio` beside it"))
        }
    }
}

/// Returns an order in which every parent precedes its children and which otherwise keeps the file's order. The error
/// is a body of a cycle.
fn parents_first(parents: &[Option<usize>]) -> Result<Vec<usize>, usize> {
    let mut order = Vec::with_capacity(parents.len());
    let mut placed = vec![false; parents.len()];
    while order.len() < parents.len() {
        let next = (0..parents.len()).find(|&body| !placed[body] && parents[body].is_none_or(|parent| placed[parent]));
        let Some(next) = next else {
            // Every remaining body descends from a cycle; following the parents long enough ends inside it.
            let mut body = placed.iter().position(|placed| !placed).unwrap_or(0);
            for _ in 0..parents.len() {
                body = parents[body].unwrap_or(body);
            }
            return Err(body);
        };
        placed[next] = true;
        order.push(next);
    }
    Ok(order)
}

fn read_body(table: &At<BodyToml>, name: &str, parent: Option<usize>, reader: &mut Reader<'_>) -> Result<Body, Fault> {
    let pivot_m = reader.point_m(&table.pivot_mm, FileNumber::BODY_PIVOT)?;
    let angle_rad = match &table.angle_deg {
        None => 0.0,
        Some(angle) => reader.scalar(angle, FileNumber::BODY_ANGLE)?.to_radians(),
    };
    let mass_kg = reader.scalar(&table.mass_g, FileNumber::BODY_MASS)? / G_PER_KG;
    let inertia_kg_m2 = reader.scalar(&table.inertia_kg_m2, FileNumber::BODY_INERTIA)?;
    let center_of_mass_m = reader.point_m(&table.center_of_mass_mm, FileNumber::BODY_CENTER)?;
    let [x, y] = center_of_mass_m;
    let point_mass = mass_kg * (x * x + y * y);
    if inertia_kg_m2 < point_mass * (1.0 - PARALLEL_AXIS_TOLERANCE) {
        return Err(Fault::at(
            table.inertia_kg_m2.value_span(),
            "less than that of a point mass at the centre of mass, which is impossible",
            format!("at least mass times squared distance, {point_mass:.3e} kg m2"),
        ));
    }
    let friction_torque_n_m = reader.scalar_or_zero(table.friction_torque_n_m.as_ref(), FileNumber::BODY_FRICTION)?;
    let (ratio, time) = (table.static_friction_ratio.as_ref(), table.dwell_s.as_ref());
    Ok(Body {
        name: name.to_owned(),
        parent,
        pivot_m,
        angle_rad,
        mass_kg,
        inertia_kg_m2,
        center_of_mass_m,
        friction_torque_n_m,
        dwell: read_dwell(
            ratio,
            time,
            friction_torque_n_m,
            [FileNumber::BODY_STATIC_RATIO, FileNumber::BODY_DWELL],
            reader,
        )?,
        viscous_n_m_s: reader.scalar_or_zero(table.viscous_n_m_s.as_ref(), FileNumber::BODY_VISCOUS)?,
        is_bend: read_bend(table, parent)?,
        turn_rad: table.turn_deg.as_ref().map(|turn| read_turn(turn, reader)).transpose()?,
    })
}

fn read_bend(table: &BodyToml, parent: Option<usize>) -> Result<bool, Fault> {
    match &table.bend {
        Some(bend) if **bend && parent.is_none() => Err(Fault::at(
            bend.span(),
            "the ground does not bend",
            "a body that is `hinged_on` another piece of the same part",
        )),
        bend => Ok(bend.as_ref().is_some_and(|bend| **bend)),
    }
}

/// Refuses a bend without stiffness: it would be a free hinge.
fn check_bends(tables: &[At<BodyToml>], instrument: &Instrument) -> Result<(), Fault> {
    for (index, body) in instrument.bodies.iter().enumerate().filter(|(_, body)| body.is_bend) {
        let stiffness: f64 = instrument
            .springs
            .iter()
            .filter(|spring| spring.body == index)
            .map(|spring| spring.stiffness_n_m_per_rad)
            .sum();
        let bend = tables.iter().find(|table| table.name.as_str() == body.name).and_then(|table| table.bend.as_ref());
        if let (false, Some(bend)) = (stiffness > 0.0, bend) {
            let expected = format!("a [[spring]] on `{}` with a stiffness greater than 0", body.name);
            return Err(Fault::at(bend.span(), "this bend has no stiffness", expected));
        }
    }
    Ok(())
}

/// Reads the range of angle that a body's stops allow, rad.
fn read_turn(turn: &Num<Pair>, reader: &mut Reader<'_>) -> Result<[f64; 2], Fault> {
    let [low, high] = reader.pair(turn, FileNumber::BODY_TURN)?;
    if !(low <= 0.0 && high >= 0.0 && low < high) {
        return Err(Fault::at(
            turn.value_span(),
            "the drawn pose, 0, must be within the range",
            "[lowest, highest] in degrees, such as [-2, 4]",
        ));
    }
    Ok([low, high].map(f64::to_radians))
}

fn read_spring(table: &At<SpringToml>, reader: &mut Reader<'_>, instrument: &Instrument) -> Result<Spring, Fault> {
    Ok(Spring {
        name: new_name(&table.name, "spring", instrument.springs.iter().map(|spring| spring.name.as_str()))?,
        body: index_of(&table.body, "body", instrument.bodies.iter().map(|body| body.name.as_str()))?,
        torque_n_m: reader.scalar(&table.torque_n_m, FileNumber::SPRING_TORQUE)?,
        stiffness_n_m_per_rad: reader.scalar(&table.stiffness_n_m_per_rad, FileNumber::SPRING_STIFFNESS)?,
    })
}

/// Returns the label; when absent, the name with spaces for underscores.
fn label(label: Option<&At<String>>, what: &str, name: &str) -> Result<String, Fault> {
    label.map_or_else(|| Ok(name.replace('_', " ")), |label| title(label, what))
}

fn read_zone(table: &At<ZoneToml>, reader: &mut Reader<'_>, instrument: &Instrument) -> Result<Zone, Fault> {
    let name = new_name(&table.name, "zone", instrument.zones.iter().map(|zone| zone.name.as_str()))?;
    // The run's columns are `<zone>_N` and `<zone>_tangential_N`, beside the finger's `force_N`.
    if name == "force" || name.ends_with("_tangential") {
        return Err(Fault::at(
            table.name.span(),
            "this name would collide with another column of a run",
            "another name",
        ));
    }
    let label = label(table.label.as_ref(), "a zone", &name)?;
    let (disc_body, disc_center_m, disc_radius_m) =
        read_disc(&table.disc, [FileNumber::DISC_CENTER, FileNumber::DISC_RADIUS], reader, instrument)?;
    let (curve_body, curve, curve_body_span) = read_curve(table, reader, instrument)?;
    if disc_body == curve_body {
        return Err(Fault::at(curve_body_span, "both sides of this zone are on the same body", "another body"));
    }
    let friction_coefficient = reader.scalar_or_zero(table.friction_coefficient.as_ref(), FileNumber::ZONE_FRICTION)?;
    let (ratio, time) = (table.static_friction_ratio.as_ref(), table.dwell_s.as_ref());
    Ok(Zone {
        name,
        label,
        disc_body,
        disc_center_m,
        disc_radius_m,
        curve_body,
        curve,
        felt: read_felt(&table.felt, reader)?,
        friction_coefficient,
        dwell: read_dwell(
            ratio,
            time,
            friction_coefficient,
            [FileNumber::ZONE_STATIC_RATIO, FileNumber::ZONE_DWELL],
            reader,
        )?,
    })
}

/// Reads a disc: its body, its centre, m, and its radius, m.
fn read_disc(
    table: &DiscToml,
    [center, radius]: [FileNumber; 2],
    reader: &mut Reader<'_>,
    instrument: &Instrument,
) -> Result<(Option<usize>, Vec2, f64), Fault> {
    let body = body_or_ground(&table.body, instrument)?;
    let center_m = reader.point_m(&table.center_mm, center)?;
    let radius_mm = reader.scalar_or_zero(table.radius_mm.as_ref(), radius)?;
    Ok((body, center_m, radius_mm / MM_PER_M))
}

/// Reads side B: its body, its curve, and the place in the text that names the body.
fn read_curve(
    table: &At<ZoneToml>,
    reader: &mut Reader<'_>,
    instrument: &Instrument,
) -> Result<(Option<usize>, Curve, Range<usize>), Fault> {
    const EXPECTED: &str = "exactly one of `line`, `segment`, `other_disc`";
    match (&table.line, &table.segment, &table.other_disc) {
        (Some(line), None, None) => {
            let body = body_or_ground(&line.body, instrument)?;
            let point_m = reader.point_m(&line.point_mm, FileNumber::LINE_POINT)?;
            let normal = reader.direction(&line.normal, FileNumber::LINE_NORMAL)?;
            Ok((body, Curve::Line { point_m, normal }, line.body.span()))
        }
        (None, Some(segment), None) => {
            let body = body_or_ground(&segment.body, instrument)?;
            let from_m = reader.point_m(&segment.from_mm, FileNumber::SEGMENT_FROM)?;
            let to_m = reader.point_m(&segment.to_mm, FileNumber::SEGMENT_TO)?;
            let rounding_mm = reader.scalar_or_zero(segment.rounding_mm.as_ref(), FileNumber::SEGMENT_ROUNDING)?;
            if libm::hypot(to_m[0] - from_m[0], to_m[1] - from_m[1]) < 1e-9 {
                let expected = "another point than `from_mm` (for a disc use `other_disc`)";
                return Err(Fault::at(segment.to_mm.value_span(), "a segment must have a length", expected));
            }
            Ok((body, Curve::Segment { from_m, to_m, rounding_m: rounding_mm / MM_PER_M }, segment.body.span()))
        }
        (None, None, Some(disc)) => {
            let (body, center_m, radius_m) =
                read_disc(disc, [FileNumber::OTHER_CENTER, FileNumber::OTHER_RADIUS], reader, instrument)?;
            if radius_m == 0.0 && table.disc.radius_mm.as_ref().is_none_or(|radius| radius.kind().0 == 0.0) {
                return Err(Fault::at(disc.span(), "two points cannot touch", "a radius on one side at least"));
            }
            Ok((body, Curve::Disc { center_m, radius_m }, disc.body.span()))
        }
        (None, None, None) => {
            Err(Fault::missing(table.span(), "line", EXPECTED).found("none of them").message("a zone needs a side B"))
        }
        (_, Some(extra), Some(_)) | (Some(_), Some(extra), None) => {
            Err(Fault::at(extra.span(), "a zone has one side B", EXPECTED).found("more than one"))
        }
        (Some(_), None, Some(extra)) => {
            Err(Fault::at(extra.span(), "a zone has one side B", EXPECTED).found("more than one"))
        }
    }
}

fn read_roles(table: &At<RolesToml>, reader: &mut Reader<'_>, instrument: &Instrument) -> Result<Roles, Fault> {
    let body = |name: &Option<At<String>>| {
        let names = instrument.bodies.iter().map(|body| body.name.as_str());
        name.as_ref().map(|name| index_of(name, "body", names)).transpose()
    };
    let zone = |name: &Option<At<String>>| name.as_ref().map(|name| zone_index(name, instrument)).transpose();
    let key = body(&table.key)?;
    let hammer = body(&table.hammer)?;
    let key_front_m = match (&table.key, &table.key_front_mm) {
        (Some(_), None) => {
            return Err(Fault::missing(table.span(), "key_front_mm", "where the finger presses the key"));
        }
        (_, Some(point)) => reader.point_m(point, FileNumber::KEY_FRONT)?,
        (None, None) => [0.0; 2],
    };
    let hammer_strike_point_m = match (&table.hammer, &table.hammer_head_mm) {
        (Some(_), None) => {
            return Err(Fault::missing(table.span(), "hammer_head_mm", "the hammer's strike point"));
        }
        (_, Some(point)) => reader.point_m(point, FileNumber::HAMMER_HEAD)?,
        (None, None) => [0.0; 2],
    };
    Ok(Roles {
        key,
        key_front_m,
        is_sharp: table.sharp,
        hammer,
        hammer_strike_point_m,
        key_bottom: zone(&table.key_bottom)?,
        string: zone(&table.string)?,
        rigid_string: table.rigid_string,
        rigid_bridge: table.rigid_bridge,
        pedal: zone(&table.pedal)?,
        let_off: zone(&table.let_off)?,
        knuckle: zone_indices(&table.knuckle, instrument)?,
        check: zone(&table.check)?,
        transmits: Vec::new(),
        stops: Vec::new(),
    })
}

fn read_one_dof(table: &OneDofToml, instrument: &mut Instrument) -> Result<(), Fault> {
    instrument.fields.roles.transmits = zone_indices(&table.transmits, instrument)?;
    instrument.fields.roles.stops = zone_indices(&table.stops, instrument)?;
    Ok(())
}

fn zone_index(name: &At<String>, instrument: &Instrument) -> Result<usize, Fault> {
    index_of(name, "zone", instrument.zones.iter().map(|zone| zone.name.as_str()))
}

/// Returns the indices of the named zones; a zone that is named twice is a fault.
fn zone_indices(names: &[At<String>], instrument: &Instrument) -> Result<Vec<usize>, Fault> {
    let mut indices = Vec::new();
    for name in names {
        let index = zone_index(name, instrument)?;
        if indices.contains(&index) {
            return Err(Fault::at(name.span(), "this zone is named twice", "every zone once"));
        }
        indices.push(index);
    }
    Ok(indices)
}

/// Reads a screw and applies its setting to the zone or spring on which it acts.
fn read_screw(table: &At<ScrewToml>, reader: &mut Reader<'_>, instrument: &mut Instrument) -> Result<Screw, Fault> {
    let name = new_name(&table.name, "screw", instrument.screws.iter().map(|screw| screw.name.as_str()))?;
    let label = label(table.label.as_ref(), "a screw", &name)?;
    let (action, setting, setting_span) = match (&table.zone, &table.spring) {
        (Some(zone), None) => {
            if let Some(setting) = &table.setting_n_m {
                return Err(misplaced(setting.span(), "`zone`"));
            }
            let zone = zone_index(zone, instrument)?;
            match &table.setting_deg {
                Some(setting) => read_turned(table, zone, setting, reader, instrument)?,
                None => read_moved(table, zone, reader)?,
            }
        }
        (None, Some(spring)) => {
            let misfit = [
                table.side.as_ref().map(At::span),
                table.direction.as_ref().map(At::span),
                table.setting_mm.as_ref().map(At::span),
                table.setting_deg.as_ref().map(At::span),
            ];
            if let Some(span) = misfit.into_iter().flatten().next() {
                return Err(misplaced(span, "`spring`"));
            }
            let spring = index_of(spring, "spring", instrument.springs.iter().map(|spring| spring.name.as_str()))?;
            let setting = needed(table, table.setting_n_m.as_ref(), "setting_N_m", "a torque, 0 as drawn")?;
            let turned = reader.scalar(setting, FileNumber::SCREW_TORQUE)?;
            (ScrewAction::Spring { spring }, turned, setting.value_span())
        }
        (Some(_), Some(spring)) => return Err(misplaced(spring.span(), "`zone`")),
        (None, None) => return Err(Fault::missing(table.span(), "zone", "`zone` or `spring`: what the screw turns")),
    };
    if !instrument.shift(&action, setting) {
        return Err(Fault::at(
            setting_span,
            "this setting cancels the spring's torque or turns it around",
            "a setting that leaves the spring pushing the same way",
        ));
    }
    Ok(Screw { name, label, action, setting })
}

/// Reads a screw that moves one side of a zone: its action, its setting, m, and the setting's place in the text.
fn read_moved(
    table: &At<ScrewToml>,
    zone: usize,
    reader: &mut Reader<'_>,
) -> Result<(ScrewAction, f64, Range<usize>), Fault> {
    let side = needed(table, table.side.as_ref(), "side", "\"disc\" or \"curve\"")?;
    let direction = needed(table, table.direction.as_ref(), "direction", "the direction of a positive setting")?;
    let direction = reader.direction(direction, FileNumber::SCREW_DIRECTION)?;
    let expected = "a length, 0 as drawn (or `setting_deg`, an angle)";
    let setting = needed(table, table.setting_mm.as_ref(), "setting_mm", expected)?;
    let action = match **side {
        ScrewSide::Disc => ScrewAction::Disc { zone, direction },
        ScrewSide::Curve => ScrewAction::Curve { zone, direction },
    };
    Ok((action, reader.scalar(setting, FileNumber::SCREW_LENGTH)? / MM_PER_M, setting.value_span()))
}

/// Reads a screw that turns a zone's curve: its action, its setting, rad, and the setting's place in the text.
fn read_turned(
    table: &At<ScrewToml>,
    zone: usize,
    setting: &Num<Real>,
    reader: &mut Reader<'_>,
    instrument: &Instrument,
) -> Result<(ScrewAction, f64, Range<usize>), Fault> {
    let misfit = [table.direction.as_ref().map(At::span), table.setting_mm.as_ref().map(At::span)];
    if let Some(span) = misfit.into_iter().flatten().next() {
        return Err(misplaced(span, "`setting_deg`"));
    }
    let side = needed(table, table.side.as_ref(), "side", "\"curve\"")?;
    if **side == ScrewSide::Disc || matches!(instrument.zones[zone].curve, Curve::Disc { .. }) {
        let message = "a disc looks the same whichever way it is turned";
        return Err(Fault::at(side.span(), message, "\"curve\", of a zone with a line or a segment"));
    }
    let turned = reader.scalar(setting, FileNumber::SCREW_ANGLE)?.to_radians();
    Ok((ScrewAction::Turn { zone }, turned, setting.value_span()))
}

fn needed<'t, T>(table: &At<ScrewToml>, value: Option<&'t T>, key: &str, expected: &str) -> Result<&'t T, Fault> {
    value.ok_or_else(|| Fault::missing(table.span(), key, expected))
}

/// Returns the fault of a key that belongs to another kind of screw.
fn misplaced(span: Range<usize>, with: &str) -> Fault {
    Fault::at(
        span,
        format!("this key does not go with {with}"),
        "a screw that moves a `zone` (setting_mm), turns it (setting_deg), or tightens a `spring` (setting_N_m)",
    )
}

fn read_part(table: &At<PartToml>, reader: &mut Reader<'_>, instrument: &Instrument) -> Result<DrawnPart, Fault> {
    let body = body_or_ground(&table.body, instrument)?;
    let outline = &table.outline_mm;
    if !(3..=MAX_CORNERS).contains(&outline.len()) {
        let message = "an outline encloses an area";
        return Err(Fault::at(outline.span(), message, format!("from 3 to {MAX_CORNERS} corners [x, y]"))
            .found(format!("{} corners", outline.len())));
    }
    let mut outline_m = Vec::with_capacity(outline.len());
    for corner in outline.iter() {
        outline_m.push(reader.corner_m(corner.0, outline.span())?);
    }
    let citation = match (&table.source, table.certainty) {
        (Some(source), Some(certainty)) => Some(reader.citation(source, certainty, None, table.note.as_deref())?),
        (Some(_), None) => {
            return Err(Fault::missing(table.span(), "certainty", "how sure the outline is"));
        }
        (None, Some(_)) => {
            return Err(Fault::missing(table.span(), "source", "where the outline comes from"));
        }
        (None, None) => None,
    };
    let values = outline.iter().flat_map(|corner| corner.0).collect();
    reader.numbers.push(ReadNumber { span: outline.span(), values, citation });
    Ok(DrawnPart {
        name: title(&table.name, "a part")?,
        body,
        material: table.material,
        outline_m,
        smooth: table.smooth,
    })
}
