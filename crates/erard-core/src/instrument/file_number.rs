//! The numbers of instrument files: where each stands, in which unit, and within which limits.

use moreau::{LAWS, LawNumber, Range};

use super::reader::{DIRECTION, LENGTH_MM, Limits};

/// A number of instrument files, of every body, spring, zone, string or screw that has it.
///
/// Its key ends with its unit, which determines its quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FileNumber {
    /// Dotted path of the table, `*` in place of the part's name: `body.*`, `zone.*.felt`. Empty for the file itself.
    pub table: &'static str,
    /// Key in the table: `mass_g`.
    pub key: &'static str,
    /// Unit for people: `g`, `degrees`; empty for a number without one.
    pub unit: &'static str,
    /// Smallest value that the reader accepts, in that unit.
    pub least: f64,
    /// Largest value that the reader accepts, in that unit.
    pub most: f64,
}

const FAR_MM: f64 = LENGTH_MM.most;
const FAR: f64 = DIRECTION.most;

/// Makes a constant of each number, and the list of all.
macro_rules! numbers {
    ($($(#[$doc:meta])* $name:ident $table:literal $key:literal $unit:literal [$least:expr, $most:expr])*) => {
        impl FileNumber {
            $(
                $(#[$doc])*
                pub const $name: Self =
                    FileNumber { table: $table, key: $key, unit: $unit, least: $least, most: $most };
            )*

            /// All but the numbers of the felts' laws.
            const LISTED: &'static [Self] = &[$(Self::$name,)*];
        }
    };
}

numbers! {
    /// Acceleration of gravity.
    GRAVITY "" "gravity_m_s2" "m/s2" [0.0, 1e3]
    /// Pivot of a body.
    BODY_PIVOT "body.*" "pivot_mm" "mm" [-FAR_MM, FAR_MM]
    /// Angle of a body as drawn.
    BODY_ANGLE "body.*" "angle_deg" "degrees" [-360.0, 360.0]
    /// Mass of a body.
    BODY_MASS "body.*" "mass_g" "g" [1e-6, 1e6]
    /// Moment of inertia of a body.
    BODY_INERTIA "body.*" "inertia_kg_m2" "kg m2" [1e-15, 1e6]
    /// Centre of mass of a body.
    BODY_CENTER "body.*" "center_of_mass_mm" "mm" [-FAR_MM, FAR_MM]
    /// Dry friction torque of a body's pivot.
    BODY_FRICTION "body.*" "friction_torque_N_m" "N m" [0.0, 1e6]
    /// Viscous friction of a body's pivot.
    BODY_VISCOUS "body.*" "viscous_N_m_s" "N m s" [0.0, 1e6]
    /// Ratio of static to kinetic friction of a body's pivot.
    BODY_STATIC_RATIO "body.*" "static_friction_ratio" "" [1.0, 100.0]
    /// Time constant with which the friction of a body's pivot grows.
    BODY_DWELL "body.*" "dwell_s" "s" [1e-6, 1e6]
    /// Stiffness of a pivot's bushing.
    BUSHING_STIFFNESS "body.*" "bushing_N_per_m" "N/m" [1e2, 1e9]
    /// Damping of a pivot's bushing.
    BUSHING_DAMPING "body.*" "bushing_N_s_per_m" "N s/m" [0.0, 1e6]
    /// Dry friction along the pin of a pivot that can lift.
    PIN_FRICTION "body.*" "pin_friction_N" "N" [0.0, 1e6]
    /// Angles that a body's stops allow.
    BODY_TURN "body.*" "turn_deg" "degrees" [-360.0, 360.0]
    /// Torque of a spring as drawn.
    SPRING_TORQUE "spring.*" "torque_N_m" "N m" [-1e6, 1e6]
    /// Stiffness of a spring.
    SPRING_STIFFNESS "spring.*" "stiffness_N_m_per_rad" "N m/rad" [0.0, 1e9]
    /// Centre of a zone's disc.
    DISC_CENTER "zone.*.disc" "center_mm" "mm" [-FAR_MM, FAR_MM]
    /// Radius of a zone's disc.
    DISC_RADIUS "zone.*.disc" "radius_mm" "mm" [0.0, FAR_MM]
    /// A point of a zone's line.
    LINE_POINT "zone.*.line" "point_mm" "mm" [-FAR_MM, FAR_MM]
    /// Normal of a zone's line.
    LINE_NORMAL "zone.*.line" "normal" "" [-FAR, FAR]
    /// One end of a zone's segment.
    SEGMENT_FROM "zone.*.segment" "from_mm" "mm" [-FAR_MM, FAR_MM]
    /// The other end of a zone's segment.
    SEGMENT_TO "zone.*.segment" "to_mm" "mm" [-FAR_MM, FAR_MM]
    /// Rounding radius of a zone's segment.
    SEGMENT_ROUNDING "zone.*.segment" "rounding_mm" "mm" [0.0, FAR_MM]
    /// Centre of a zone's second disc.
    OTHER_CENTER "zone.*.other_disc" "center_mm" "mm" [-FAR_MM, FAR_MM]
    /// Radius of a zone's second disc.
    OTHER_RADIUS "zone.*.other_disc" "radius_mm" "mm" [0.0, FAR_MM]
    /// Stiffness k of a felt's spring k g^r.
    FELT_STIFFNESS "zone.*.felt" "stiffness_N_per_m_r" "N/m^r" [0.0, 1e18]
    /// Exponent r of a felt's spring k g^r.
    FELT_EXPONENT "zone.*.felt" "exponent" "" [1.0, 6.0]
    /// Thickness of a felt.
    FELT_THICKNESS "zone.*.felt" "thickness_mm" "mm" [1e-3, 1e3]
    /// Friction coefficient of a zone.
    ZONE_FRICTION "zone.*" "friction_coefficient" "" [0.0, 100.0]
    /// Ratio of static to kinetic friction of a zone.
    ZONE_STATIC_RATIO "zone.*" "static_friction_ratio" "" [1.0, 100.0]
    /// Time constant with which the friction of a zone grows.
    ZONE_DWELL "zone.*" "dwell_s" "s" [1e-6, 1e6]
    /// Speaking length of a string.
    STRING_LENGTH "string.*" "length_mm" "mm" [10.0, 1e4]
    /// Diameter of a string's wire.
    STRING_DIAMETER "string.*" "diameter_mm" "mm" [0.1, 20.0]
    /// Mass per length of a string.
    STRING_MASS "string.*" "mass_g_per_m" "g/m" [1e-2, 1e4]
    /// Frequency of a string's first partial.
    STRING_FREQUENCY "string.*" "frequency_Hz" "Hz" [10.0, 2e4]
    /// Tension of a string.
    STRING_TENSION "string.*" "tension_N" "N" [1.0, 1e5]
    /// Inharmonicity of a string.
    STRING_INHARMONICITY "string.*" "inharmonicity" "" [0.0, 1.0]
    /// Detuning of a string: an octave at most.
    STRING_DETUNING "string.*" "detuned_cents" "cents" [-1200.0, 1200.0]
    /// Loss of all partials of a string.
    STRING_LOSS "string.*" "loss_per_s" "1/s" [0.0, 1e4]
    /// Loss of a string that grows with the frequency.
    STRING_HIGH_LOSS "string.*" "loss_s" "s" [0.0, 1.0]
    /// Striking point of a string.
    STRING_STRIKE "string.*" "strike_mm" "mm" [0.1, 1e4]
    /// A string's part of the hammer's force.
    STRING_SHARE "string.*" "strike_share" "" [1e-3, 1e3]
    /// Angle of the blow on a string.
    STRING_ANGLE "string.*" "strike_angle_deg" "degrees" [-45.0, 45.0]
    /// Middle of a damper's felt.
    DAMPER_MIDDLE "string.*.damper" "middle_mm" "mm" [0.1, 1e4]
    /// Length of a damper's felt.
    DAMPER_LENGTH "string.*.damper" "length_mm" "mm" [0.1, 1e4]
    /// Mass of a bridge mode.
    BRIDGE_MASS "bridge_mode.*" "mass_g" "g" [1.0, 1e6]
    /// Frequency of a bridge mode.
    BRIDGE_FREQUENCY "bridge_mode.*" "frequency_Hz" "Hz" [1.0, 2e4]
    /// Loss factor of a bridge mode.
    BRIDGE_LOSS "bridge_mode.*" "loss_factor" "" [0.0, 0.99]
    /// Horizontal motion of a bridge mode.
    BRIDGE_HORIZONTAL "bridge_mode.*" "horizontal" "" [-100.0, 100.0]
    /// Lower end of a band of the soundboard.
    BOARD_FROM "board.*" "from_Hz" "Hz" [1.0, 2e4]
    /// Upper end of a band of the soundboard.
    BOARD_TO "board.*" "to_Hz" "Hz" [1.0, 2e4]
    /// Modal density of a band of the soundboard.
    BOARD_DENSITY "board.*" "modal_density_s" "s" [1e-6, 10.0]
    /// Effective mass of a mode of a band of the soundboard.
    BOARD_MASS "board.*" "mass_g" "g" [1.0, 1e6]
    /// Loss factor of a band of the soundboard.
    BOARD_LOSS "board.*" "loss_factor" "" [0.0, 0.99]
    /// Horizontal motion of a band of the soundboard.
    BOARD_HORIZONTAL "board.*" "horizontal" "" [0.0, 100.0]
    /// Point of the key that the finger presses.
    KEY_FRONT "roles" "key_front_mm" "mm" [-FAR_MM, FAR_MM]
    /// Strike point of the hammer.
    HAMMER_HEAD "roles" "hammer_head_mm" "mm" [-FAR_MM, FAR_MM]
    /// Stiffness of the fingertip.
    FINGER_STIFFNESS "finger" "stiffness_N_per_m" "N/m" [1e-3, 1e9]
    /// Damping of the fingertip.
    FINGER_DAMPING "finger" "damping_N_s_per_m" "N s/m" [0.0, 1e6]
    /// Direction of a screw.
    SCREW_DIRECTION "screw.*" "direction" "" [-FAR, FAR]
    /// Setting of a screw that moves a side of a zone.
    SCREW_LENGTH "screw.*" "setting_mm" "mm" [-FAR_MM, FAR_MM]
    /// Setting of a screw that turns a curve.
    SCREW_ANGLE "screw.*" "setting_deg" "degrees" [-90.0, 90.0]
    /// Setting of a screw that tightens a spring.
    SCREW_TORQUE "screw.*" "setting_N_m" "N m" [-1e6, 1e6]
}

impl FileNumber {
    /// All numbers. A number that several laws of felts share is listed once.
    pub fn all() -> impl Iterator<Item = FileNumber> {
        let laws = || LAWS.iter().copied().flatten();
        let first =
            move |(n, number): &(usize, &LawNumber)| laws().position(|other| other.key == number.key) == Some(*n);
        let of_laws = laws().enumerate().filter(first).map(|(_, number)| FileNumber::of_law(number));
        FileNumber::LISTED.iter().copied().chain(of_laws)
    }

    /// Number of a felt's law.
    #[must_use]
    pub fn of_law(number: &LawNumber) -> FileNumber {
        let [least, most] = match number.range {
            Range::Part => [0.0, 0.99],
            Range::InnerPart => [1e-3, 0.99],
            Range::Between(least, most) => [least * number.units_per_si, most * number.units_per_si],
            Range::UpTo(most) => [0.0, most * number.units_per_si],
            _ => [0.0, f64::MAX],
        };
        let unit = if number.unit == "1" { "" } else { number.unit };
        FileNumber { table: Self::FELT_STIFFNESS.table, key: number.key, unit, least, most }
    }

    /// Finds the number at a path, `zone.check.felt.exponent`; of a point also at a coordinate's, with `.x` or `.y`.
    #[must_use]
    pub fn of_path(path: &str) -> Option<FileNumber> {
        let path = path.strip_suffix(".x").or_else(|| path.strip_suffix(".y")).unwrap_or(path);
        Self::all().find(|number| number.part_of(path).is_some())
    }

    /// Path of the number of a part: `body.hammer.mass_g`. Numbers of the file itself ignore the part.
    #[must_use]
    pub fn path(&self, part: &str) -> String {
        let Self { table, key, .. } = self;
        if table.is_empty() { (*key).to_owned() } else { format!("{}.{key}", table.replacen('*', part, 1)) }
    }

    /// Name of the part whose number is at a path, empty for the file itself; `None` if another number is there.
    #[must_use]
    pub fn part_of<'p>(&self, path: &'p str) -> Option<&'p str> {
        let table = path.strip_suffix(self.key)?;
        let Some((before, after)) = self.table.split_once('*') else {
            return (path == self.path("")).then_some("");
        };
        let part = table.strip_prefix(before)?.strip_suffix('.')?.strip_suffix(after)?;
        (!part.is_empty() && !part.contains('.')).then_some(part)
    }
}

impl From<FileNumber> for Limits {
    fn from(FileNumber { least, most, unit, .. }: FileNumber) -> Self {
        Limits { least, most, unit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every number is found at its own path and at no other's.
    #[test]
    fn a_path_is_one_numbers() {
        assert_eq!(FileNumber::of_path("roleskey_front_mm"), None, "a dot is missing");
        for number in FileNumber::all() {
            let path = number.path("hammer");
            assert_eq!(FileNumber::of_path(&path), Some(number), "{path}");
            assert_eq!(FileNumber::of_path(&format!("{path}.y")), Some(number), "{path}");
            let found = FileNumber::all().filter(|other| other.part_of(&path).is_some()).count();
            assert_eq!(found, 1, "{path}");
        }
        for path in ["", "body.hammer", "body..mass_g", "body.a.b.mass_g", "mass_g", "zone.check.exponent", "xfinger.a"]
        {
            assert_eq!(FileNumber::of_path(path), None, "{path}");
        }
    }
}
