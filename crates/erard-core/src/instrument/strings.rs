//! Reads the strings of an instrument file.

use std::ops::Range;

use super::board::Band;
use super::error::Fault;
use super::file_number::FileNumber;
use super::format::{BoardToml, BridgeModeToml, DamperToml, StringToml};
use super::quantity::At;
use super::reader::{G_PER_KG, MM_PER_M, Reader, index_of, new_name};
use super::tuning::{STEEL_DENSITY_KG_M3, bending_stiffness, tension_for};
use super::{BridgeMode, DamperFelt, Instrument, MAX_BRIDGE_MODES, MAX_STRINGS, PianoString, Zone};

/// Cents in an octave.
const OCTAVE_CENTS: f64 = 1200.0;

/// Reads the strings. Zones and roles must have been read before.
pub(super) fn read_strings(
    tables: &[At<StringToml>],
    pedal: Option<&At<String>>,
    reader: &mut Reader<'_>,
    instrument: &mut Instrument,
) -> Result<(), Fault> {
    if let Some(table) = tables.get(MAX_STRINGS) {
        let expected = format!("at most {MAX_STRINGS} strings, those of one note");
        return Err(Fault::at(table.span(), "too many strings", expected).found(format!("{} strings", tables.len())));
    }
    for table in tables {
        let zone = instrument.roles.string.map(|zone| &instrument.zones[zone]);
        let Some(zone) = zone else {
            let expected = "`string` in [roles], the zone between hammer and string";
            return Err(Fault::at(table.span(), "no zone strikes this string", expected));
        };
        check_zone(zone, table.span())?;
        if let Some(name) = instrument.zones.iter().map(|zone| &zone.name).find(|name| *name == "bridge") {
            let message =
                format!("a zone is named `{name}`, but a run with strings has a column `{name}_N` for the bridge");
            return Err(Fault::at(table.span(), message, "another name for that zone"));
        }
        let mut string = read_string(table, reader, &instrument.strings)?;
        string.damper =
            table.damper.as_ref().map(|damper| read_damper(damper, &string, reader, instrument)).transpose()?;
        instrument.fields.strings.push(string);
    }
    if let (Some(zone), Some(name)) = (instrument.roles.pedal, pedal) {
        if instrument.roles.string == Some(zone) {
            return Err(Fault::at(
                name.span(),
                "the pedal's zone cannot be the hammer's",
                "the zone between the damper's lever and the pedal's rail",
            ));
        }
        if !instrument.strings.is_empty() {
            check_zone(&instrument.zones[zone], name.span())?;
        }
    }
    Ok(())
}

fn read_string(table: &At<StringToml>, reader: &mut Reader<'_>, others: &[PianoString]) -> Result<PianoString, Fault> {
    let name = new_name(&table.name, "string", others.iter().map(|string| string.name.as_str()))?;
    let length_m = reader.scalar(&table.length_mm, FileNumber::STRING_LENGTH)? / MM_PER_M;
    let diameter = table.diameter_mm.as_ref();
    let diameter_m =
        diameter.map(|mm| reader.scalar(mm, FileNumber::STRING_DIAMETER)).transpose()?.map(|mm| mm / MM_PER_M);
    let mass_kg_per_m = match (&table.mass_g_per_m, diameter_m) {
        (Some(mass), _) => reader.scalar(mass, FileNumber::STRING_MASS)? / G_PER_KG,
        (None, Some(d)) => STEEL_DENSITY_KG_M3 * std::f64::consts::FRAC_PI_4 * d * d,
        (None, None) => {
            return Err(Fault::missing(table.span(), "diameter_mm", "the wire's diameter, or `mass_g_per_m`"));
        }
    };
    let inharmonicity = match &table.inharmonicity {
        Some(b) => Some(reader.scalar(b, FileNumber::STRING_INHARMONICITY)?),
        None => None,
    };
    let bending = match (inharmonicity, diameter_m) {
        (Some(_), _) => 0.0,
        (None, Some(d)) => bending_stiffness(d),
        (None, None) => {
            return Err(Fault::missing(table.span(), "inharmonicity", "B, or the wire's `diameter_mm`"));
        }
    };
    // B = pi^2 EI / (T L^2), and f^2 = f0^2 (1 + B).
    let (base_n, span) = match (&table.frequency_hz, &table.tension_n) {
        (Some(hz), None) => {
            let f = reader.scalar(hz, FileNumber::STRING_FREQUENCY)?;
            let stiff_n = tension_for(f, length_m, mass_kg_per_m, bending);
            (inharmonicity.map_or(stiff_n, |b| stiff_n / (1.0 + b)), hz.value_span())
        }
        (None, Some(tension)) => (reader.scalar(tension, FileNumber::STRING_TENSION)?, tension.value_span()),
        (None, None) => {
            return Err(Fault::missing(table.span(), "frequency_Hz", "the first partial's frequency, or `tension_N`"));
        }
        (Some(_), Some(tension)) => {
            let expected = "either `frequency_Hz` or `tension_N`";
            return Err(Fault::at(tension.span(), "a string is tuned once", expected).found("both"));
        }
    };
    let cents = reader.scalar_or_zero(table.detuned_cents.as_ref(), FileNumber::STRING_DETUNING)?;
    if base_n.is_nan() || base_n < 1.0 {
        let expected = "a longer, thinner or higher string: a tension of at least 1 N";
        return Err(Fault::at(span, "the tension of this string is below 1 N", expected)
            .found(format!("a tension of {base_n:.3} N")));
    }
    // Frequencies vary with the square root of the tension. The part of bending in the first partial stays constant, in
    // cents, to a thousandth.
    let tension_n = base_n * libm::exp2(2.0 * cents / OCTAVE_CENTS);
    let square = std::f64::consts::PI * std::f64::consts::PI;
    let bending_n_m2 = inharmonicity.map_or(bending, |b| b * tension_n * length_m * length_m / square);
    let strike_m = reader.scalar(&table.strike_mm, FileNumber::STRING_STRIKE)? / MM_PER_M;
    if strike_m >= length_m {
        let expected = format!("a place on the string, less than {} mm", length_m * MM_PER_M);
        return Err(Fault::at(table.strike_mm.value_span(), "the striking point is beyond the string", expected));
    }
    Ok(PianoString {
        name,
        length_m,
        mass_kg_per_m,
        tension_n,
        bending_n_m2,
        loss_per_s: reader.scalar(&table.loss_per_s, FileNumber::STRING_LOSS)?,
        loss_s: reader.scalar_or_zero(table.loss_s.as_ref(), FileNumber::STRING_HIGH_LOSS)?,
        strike_m,
        strike_share: table
            .strike_share
            .as_ref()
            .map_or(Ok(1.0), |share| reader.scalar(share, FileNumber::STRING_SHARE))?,
        strike_angle_rad: table
            .strike_angle_deg
            .as_ref()
            .map(|angle| reader.scalar(angle, FileNumber::STRING_ANGLE))
            .transpose()?
            .map(f64::to_radians),
        damper: None,
    })
}

/// Reads the damper's felt on a string.
fn read_damper(
    table: &At<DamperToml>,
    string: &PianoString,
    reader: &mut Reader<'_>,
    instrument: &Instrument,
) -> Result<DamperFelt, Fault> {
    let zone = index_of(&table.zone, "zone", instrument.zones.iter().map(|zone| zone.name.as_str()))?;
    let span = table.zone.span();
    let used = instrument.strings.iter().any(|other| other.damper.is_some_and(|damper| damper.zone == zone));
    if used || instrument.roles.string == Some(zone) || instrument.roles.pedal == Some(zone) {
        return Err(Fault::at(span, "this zone already touches something else", "a zone for each damped string"));
    }
    check_zone(&instrument.zones[zone], span)?;
    let middle_m = reader.scalar(&table.middle_mm, FileNumber::DAMPER_MIDDLE)? / MM_PER_M;
    let length_m = reader.scalar(&table.length_mm, FileNumber::DAMPER_LENGTH)? / MM_PER_M;
    if middle_m - 0.5 * length_m < 0.0 || middle_m + 0.5 * length_m > string.length_m {
        let expected = format!("a felt between 0 and {} mm", string.length_m * MM_PER_M);
        return Err(Fault::at(table.middle_mm.value_span(), "the damper extends beyond the string", expected));
    }
    Ok(DamperFelt { zone, middle_m, length_m })
}

/// Reads the modes of the bridge.
pub(super) fn read_bridge(
    tables: &[At<BridgeModeToml>],
    reader: &mut Reader<'_>,
    instrument: &mut Instrument,
) -> Result<(), Fault> {
    if let Some(table) = tables.get(MAX_BRIDGE_MODES) {
        let expected = format!("at most {MAX_BRIDGE_MODES} modes");
        return Err(
            Fault::at(table.span(), "too many modes of the bridge", expected).found(format!("{}", tables.len()))
        );
    }
    for table in tables {
        if instrument.strings.is_empty() {
            return Err(Fault::at(table.span(), "a bridge mode needs strings", "a [[string]]"));
        }
        let others = instrument.bridge_modes.iter().map(|mode| mode.name.as_str());
        let name = new_name(&table.name, "bridge mode", others)?;
        instrument.fields.bridge_modes.push(BridgeMode {
            name,
            mass_kg: reader.scalar(&table.mass_g, FileNumber::BRIDGE_MASS)? / G_PER_KG,
            frequency_hz: reader.scalar(&table.frequency_hz, FileNumber::BRIDGE_FREQUENCY)?,
            loss_factor: reader.scalar(&table.loss_factor, FileNumber::BRIDGE_LOSS)?,
            horizontal: reader.scalar_or_zero(table.horizontal.as_ref(), FileNumber::BRIDGE_HORIZONTAL)?,
        });
    }
    Ok(())
}

/// Reads the bands of the soundboard, and draws their modes. Modes that are listed must have been read before.
pub(super) fn read_board(
    tables: &[At<BoardToml>],
    reader: &mut Reader<'_>,
    instrument: &mut Instrument,
) -> Result<(), Fault> {
    let mut names: Vec<String> = Vec::new();
    for table in tables {
        if instrument.strings.is_empty() {
            return Err(Fault::at(table.span(), "a soundboard needs strings", "a [[string]]"));
        }
        let name = new_name(&table.name, "band", names.iter().map(String::as_str))?;
        let seed = table.seed.as_ref().map_or(Ok(0), |seed| {
            u64::try_from(**seed).map_err(|_| Fault::at(seed.span(), "not a seed", "a whole number from 0"))
        })?;
        let band = Band {
            hz: [
                reader.scalar(&table.from_hz, FileNumber::BOARD_FROM)?,
                reader.scalar(&table.to_hz, FileNumber::BOARD_TO)?,
            ],
            modes_per_hz: reader.scalar(&table.modal_density_s, FileNumber::BOARD_DENSITY)?,
            mass_kg: reader.scalar(&table.mass_g, FileNumber::BOARD_MASS)? / G_PER_KG,
            loss_factor: reader.scalar(&table.loss_factor, FileNumber::BOARD_LOSS)?,
            horizontal: reader.scalar_or_zero(table.horizontal.as_ref(), FileNumber::BOARD_HORIZONTAL)?,
        };
        let [from_hz, to_hz] = band.hz;
        if from_hz >= to_hz {
            let expected = format!("more than its lower end, {from_hz} Hz");
            return Err(Fault::at(table.to_hz.value_span(), "the band's upper end is too low", expected)
                .found(format!("{to_hz} Hz")));
        }
        let free = MAX_BRIDGE_MODES.saturating_sub(instrument.bridge_modes.len());
        if band.count() > free {
            let expected = format!("at most {MAX_BRIDGE_MODES} modes of the bridge in all");
            return Err(Fault::at(table.modal_density_s.value_span(), "too many modes of the soundboard", expected)
                .found(format!("{} in this band, {free} are left", band.count())));
        }
        instrument.fields.bridge_modes.extend(band.modes(&name, seed));
        names.push(name);
    }
    Ok(())
}

/// Refuses a zone that cannot press on modal strings: its loss is set-valued, or its side B is on a body.
fn check_zone(zone: &Zone, span: Range<usize>) -> Result<(), Fault> {
    if matches!(zone.felt.loss, moreau::Loss::SetValued(_)) {
        let message = format!("the felt of `{}` has a set-valued loss, which modal strings do not support", zone.name);
        return Err(Fault::at(span, message, "`dry_slip` beside its `dry_loss`, or another loss"));
    }
    if zone.curve_body.is_some() {
        let message = format!("side B of the zone `{}` is on a body", zone.name);
        return Err(Fault::at(span, message, "a zone whose side B is on the ground"));
    }
    Ok(())
}
