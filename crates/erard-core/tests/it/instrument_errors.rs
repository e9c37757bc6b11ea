//! Every way in which an instrument file can be wrong gives one message with line, key, what was found and what was
//! expected.

use erard::instrument::{FileError, Instrument, InstrumentFile, MAX_FILE_BYTES};

const CLOCK: &str = include_str!("../instruments/escapement.toml");

/// One slip of the pen in a file that reads.
struct Slip {
    /// Text of the good file, and what stands there instead.
    change: (&'static str, &'static str),
    /// A piece of the line that the error must name: the first such line at or after the change's own.
    line_with: &'static str,
    key: &'static str,
    /// What `found`, `expected` and `message` must contain, in this order.
    says: [&'static str; 3],
}

fn error_of(text: &str) -> Box<FileError> {
    match Instrument::parse(text, "clock.toml") {
        Ok(_) => panic!("this should not read:\n{text}"),
        Err(error) => error,
    }
}

fn check(slips: &[Slip]) {
    for Slip { change: (good, bad), line_with, key, says: [found, expected, message] } in slips {
        let at = CLOCK.find(good).unwrap_or_else(|| panic!("`{good}` is not in the good file"));
        let text = CLOCK.replacen(good, bad, 1);
        let error = error_of(&text);
        let shown = format!("{good:?} -> {bad:?}: {error}");

        let change_line = text[..at].matches('\n').count();
        let line = text
            .lines()
            .enumerate()
            .filter(|(_, line)| line.contains(line_with))
            .map(|(index, _)| index)
            .min_by_key(|index| index.abs_diff(change_line))
            .unwrap_or_else(|| panic!("no line with `{line_with}`"));
        assert_eq!(error.line, line + 1, "line of {shown}");
        assert_eq!(error.key, *key, "key of {shown}");
        assert!(error.found.contains(found), "found of {shown}");
        assert!(error.expected.contains(expected), "expected of {shown}");
        assert!(error.message.contains(message), "message of {shown}");
        assert_eq!(error.file, "clock.toml");

        // What the command underlines, and the one line it prints.
        assert_eq!(&*error.text, text.as_str());
        assert!(text.get(error.span.clone()).is_some(), "span of {shown}");
        let column = text.lines().nth(line).map_or(0, |line| line.chars().count()) + 1;
        assert!((1..=column).contains(&error.column), "column of {shown}");
        assert!(error.to_string().starts_with(&format!("clock.toml:{}:", error.line)));
        assert!(!error.to_string().contains('\n'), "one line: {shown}");
    }
}

fn slip(
    change: (&'static str, &'static str),
    line_with: &'static str,
    key: &'static str,
    says: [&'static str; 3],
) -> Slip {
    Slip { change, line_with, key, says }
}

#[test]
fn numbers_that_no_instrument_has() {
    let mass = "mass_g = 250";
    let key = "body.pendulum.mass_g";
    let positive = "a number greater than 0";
    check(&[
        slip((mass, "mass_g = -250"), "mass_g = -250", key, ["-250", positive, "negative"]),
        slip((mass, "mass_g = 0"), "mass_g = 0", key, ["0", positive, "zero"]),
        slip((mass, "mass_g = nan"), "mass_g = nan", key, ["nan", positive, "finite"]),
        slip((mass, "mass_g = -inf"), "mass_g = -inf", key, ["-inf", positive, "finite"]),
        slip((mass, "mass_g = 1e300"), "1e300", key, ["1e300", "at most 1e6 g", "too large"]),
        slip((mass, "mass_g = 1e-300"), "1e-300", key, ["1e-300", "at least 1e-6 g", "too small"]),
        slip((mass, "mass_g = 1e999"), "1e999", key, ["1e999", "", ""]),
        slip((mass, "mass_g = 99999999999999999999"), "9999", key, ["9999", positive, "wrong kind"]),
        slip(
            ("inertia_kg_m2 = 0.01", "inertia_kg_m2 = 0"),
            "inertia_kg_m2 = 0",
            "body.pendulum.inertia_kg_m2",
            ["0", positive, "zero"],
        ),
        // 250 g at 190 mm alone are 9.0e-3 kg m2.
        slip(
            ("inertia_kg_m2 = 0.01", "inertia_kg_m2 = 0.009"),
            "inertia_kg_m2 = 0.009",
            "body.pendulum.inertia_kg_m2",
            ["0.009", "9.025e-3", "impossible"],
        ),
        slip(
            ("friction_torque_N_m = 1e-4", "friction_torque_N_m = -1e-4"),
            "-1e-4",
            "body.pendulum.friction_torque_N_m",
            ["-1e-4", "not negative", "negative"],
        ),
        slip(
            ("viscous_N_m_s = 1e-6", "viscous_N_m_s = -1"),
            "viscous_N_m_s = -1",
            "body.pallet.viscous_N_m_s",
            ["-1", "", "negative"],
        ),
        slip(
            ("stiffness_N_m_per_rad = 0.02", "stiffness_N_m_per_rad = -0.02"),
            "-0.02",
            "spring.pallet_return.stiffness_N_m_per_rad",
            ["-0.02", "", "negative"],
        ),
        slip(
            ("torque_N_m = 0\n", "torque_N_m = nan\n"),
            "torque_N_m = nan",
            "spring.pallet_return.torque_N_m",
            ["nan", "a number", "finite"],
        ),
        slip(
            ("stiffness_N_per_m_r = 1e8", "stiffness_N_per_m_r = -1e8"),
            "-1e8",
            "zone.bench.felt.stiffness_N_per_m_r",
            ["-1e8", "", "negative"],
        ),
        slip(
            ("damping_N_s_per_m3 = 1e6", "damping_N_s_per_m3 = -1"),
            "damping_N_s_per_m3 = -1",
            "zone.pallet_lever.felt.damping_N_s_per_m3",
            ["-1", "", "negative"],
        ),
        slip(
            ("damping_N_s_per_m3 = 1e6", "damping_N_s_per_m3 = 1e6\nhunt_crossley_s_per_m = 0.5"),
            "0.5",
            "zone.pallet_lever.felt.hunt_crossley_s_per_m",
            ["both", "either `damping_N_s_per_m3` or `hunt_crossley_s_per_m`", "one law"],
        ),
        slip(
            ("damping_N_s_per_m3 = 1e6", "hunt_crossley_s_per_m = -0.5"),
            "-0.5",
            "zone.pallet_lever.felt.hunt_crossley_s_per_m",
            ["-0.5", "", "negative"],
        ),
        slip(
            ("damping_N_s_per_m3 = 1e6", "dry_loss = 1.2"),
            "dry_loss = 1.2",
            "zone.pallet_lever.felt.dry_loss",
            ["1.2", "0.99", "too large"],
        ),
        slip(
            ("damping_N_s_per_m3 = 1e6", "hunt_crossley_s_per_m = 0.5\ndry_loss = 0.2"),
            "dry_loss = 0.2",
            "zone.pallet_lever.felt.dry_loss",
            ["both", "either `hunt_crossley_s_per_m` or `dry_loss`", "one law"],
        ),
        slip(
            ("damping_N_s_per_m3 = 1e6", "damping_N_s_per_m3 = 1e6\nrelaxed = 0.2\nrelaxation_ms = 1"),
            "relaxed = 0.2",
            "zone.pallet_lever.felt.relaxed",
            ["both", "either `damping_N_s_per_m3` or `relaxed`", "one law"],
        ),
        slip(
            ("damping_N_s_per_m3 = 1e6", "dry_slip = 0.2"),
            "dry_slip = 0.2",
            "zone.pallet_lever.felt.dry_slip",
            ["", "`dry_loss` beside it", "needs another"],
        ),
        slip(
            ("friction_coefficient = 0.1", "friction_coefficient = 0.1\ndwell_s = 0.2"),
            "dwell_s = 0.2",
            "zone.pallet_lever.dwell_s",
            ["", "`static_friction_ratio` beside it", "needs another"],
        ),
        slip(
            ("friction_coefficient = 0.1", "friction_coefficient = 0.1\ndwell_s = 0.2\nstatic_friction_ratio = 0.9"),
            "static_friction_ratio = 0.9",
            "zone.pallet_lever.static_friction_ratio",
            ["0.9", "at least 1", "too small"],
        ),
        slip(
            ("viscous_N_m_s = 1e-6", "viscous_N_m_s = 1e-6\nbushing_N_per_m = 1"),
            "bushing_N_per_m = 1",
            "body.pallet.bushing_N_per_m",
            ["1", "at least 100", "too small"],
        ),
        slip(
            ("viscous_N_m_s = 1e-6", "viscous_N_m_s = 1e-6\nbushing_N_s_per_m = 1"),
            "bushing_N_s_per_m = 1",
            "body.pallet.bushing_N_s_per_m",
            ["", "`bushing_N_per_m` beside it", "needs another"],
        ),
        slip(
            ("viscous_N_m_s = 1e-6", "viscous_N_m_s = 1e-6\npin_friction_N = 0.3"),
            "pin_friction_N = 0.3",
            "body.pallet.pin_friction_N",
            [
                "0.3",
                "a [[zone]] whose disc is on `pallet` at its pivot, [0, 0], and its line on `pendulum`",
                "nothing holds this pivot",
            ],
        ),
        slip(
            ("viscous_N_m_s = 1e-6", "viscous_N_m_s = 1e-6\nbushing_N_per_m = 1e5\npin_friction_N = 0.3"),
            "pin_friction_N = 0.3",
            "body.pallet.pin_friction_N",
            ["both", "either `bushing_N_per_m` or `pin_friction_N`", "one bushing"],
        ),
        slip(("exponent = 2", "exponent = 0.5"), "0.5", "zone.bench.felt.exponent", ["0.5", "at least 1", "too small"]),
        slip(("exponent = 2", "exponent = 40"), "40", "zone.bench.felt.exponent", ["40", "at most 6", "too large"]),
        slip(
            ("friction_coefficient = 0.1", "friction_coefficient = -0.1"),
            "-0.1",
            "zone.pallet_lever.friction_coefficient",
            ["-0.1", "", "negative"],
        ),
        slip(
            ("radius_mm = 3", "radius_mm = -3"),
            "radius_mm = -3",
            "zone.pallet_lever.other_disc.radius_mm",
            ["-3", "", "negative"],
        ),
        slip(
            ("pivot_mm = [60, 0]", "pivot_mm = [60, inf]"),
            "inf",
            "body.lever.pivot_mm",
            ["[60, inf]", "[x, y]", "finite"],
        ),
        slip(
            ("pivot_mm = [60, 0]", "pivot_mm = [6e7, 0]"),
            "6e7",
            "body.lever.pivot_mm",
            ["6e7", "at most 10000 mm", "large"],
        ),
        slip(
            ("pivot_mm = [60, 0]", "pivot_mm = [-6e7, 0]"),
            "6e7",
            "body.lever.pivot_mm",
            ["6e7", "at least -10000 mm", "small"],
        ),
        slip(("angle_deg = 90", "angle_deg = 900"), "900", "body.pallet.angle_deg", ["900", "360 degrees", "large"]),
        slip(("gravity_m_s2 = 9.81", "gravity_m_s2 = -9.81"), "gravity", "gravity_m_s2", ["-9.81", "", "negative"]),
        slip(
            ("normal = [0, 2]", "normal = [0, 0.0]"),
            "normal",
            "zone.bench.line.normal",
            ["[0, 0.0]", "not both 0", "length"],
        ),
    ]);
}

#[test]
fn keys_that_are_wrong_or_absent() {
    check(&[
        // The unit is part of the key: without it nobody knows what the number means.
        slip(("mass_g = 250", "mass = 250"), "mass = 250", "body.pendulum.mass", ["`mass`", "`mass_g`", "unknown key"]),
        slip(
            ("mass_g = 250", "mass_kg = 0.25"),
            "mass_kg",
            "body.pendulum.mass_kg",
            ["`mass_kg`", "`mass_g`", "unknown key"],
        ),
        slip(("pivot_mm = [60", "pivto_mm = [60"), "pivto", "body.lever.pivto_mm", ["`pivto_mm`", "`pivot_mm`", ""]),
        slip(("angle_deg", "colour"), "colour", "body.pallet.colour", ["`colour`", "`mass_g`", "unknown key"]),
        slip(("[[body]]", "[[bodies]]"), "[[bodies]]", "bodies", ["`bodies`", "`body`", "unknown key"]),
        slip(("mass_g = 250\n", ""), "[[body]]", "body.pendulum.mass_g", ["", "mass_g", "missing"]),
        slip(("name = \"lever\"\n", ""), "[[body]]", "body[3].name", ["", "name", "missing"]),
        slip(
            ("[zone.disc]\nbody = \"lever\"\ncenter_mm = [-50, -1]\n", ""),
            "[[zone]]",
            "zone.bench.disc",
            ["", "[zone.disc]", "missing"],
        ),
        slip(("normal = [0, 2]\n", ""), "[zone.line]", "zone.bench.line.normal", ["", "normal", "missing"]),
        slip(
            ("[zone.line]\nbody = \"ground\"\npoint_mm = [0, -2]\nnormal = [0, 2]\n", ""),
            "[[zone]]",
            "zone.bench.line",
            ["none", "exactly one of `line`, `segment`, `other_disc`", "side B"],
        ),
        slip(
            ("[zone.line]", "[zone.other_disc]\nbody = \"ground\"\ncenter_mm = [0, 0]\n[zone.line]"),
            "[zone.other_disc]",
            "zone.bench.other_disc",
            ["more than one", "exactly one", "one side B"],
        ),
        slip(("mass_g = 250", "mass_g = 250\nmass_g = 251"), "mass_g = 251", "mass_g", ["`mass_g`", "", "duplicate"]),
        slip(("format = \"erard-instrument/1\"\n", ""), "A mechanism", "format", ["", "format", "missing"]),
        slip(
            ("erard-instrument/1", "erard-instrument/9"),
            "format",
            "format",
            ["erard-instrument/9", "erard-instrument/1", "format"],
        ),
        slip(("\"Pendulum and pallet\"", "\" \""), "name = \" \"", "name", ["\" \"", "a name", "needs a name"]),
    ]);
}

#[test]
fn values_of_the_wrong_kind() {
    let mass = "mass_g = 250";
    let key = "body.pendulum.mass_g";
    check(&[
        slip((mass, "mass_g = \"250\""), "\"250\"", key, ["\"250\"", "`250g` (units: kg, g,", "needs its unit"]),
        slip((mass, "mass_g = \"heavy\""), "\"heavy\"", key, ["\"heavy\"", "a number greater than 0", "wrong kind"]),
        slip((mass, "mass_g = \"250mm\""), "\"250mm\"", key, ["\"250mm\"", "kg, g, mg, oz, lb", "`mm` is not one"]),
        slip((mass, "mass_g = \"1,250g\""), "\"1,2", key, ["\"1,250g\"", "`1.250g` or `1250g`", "two meanings"]),
        slip((mass, "mass_g = \"-250g\""), "\"-250", key, ["\"-250g\"", "a number greater than 0", ""]),
        slip((mass, "mass_g = true"), "true", key, ["true", "a number", "wrong kind"]),
        slip((mass, "mass_g = [250]"), "[250]", key, ["[250]", "a number", "wrong kind"]),
        slip((mass, "mass_g = 1979-05-27"), "1979", key, ["1979-05-27", "a number", "wrong kind"]),
        slip((mass, "mass_g = # grams"), "# grams", "mass_g", ["", "a value", "no value"]),
        slip(("pivot_mm = [60, 0]", "pivot_mm = 60"), "= 60", "body.lever.pivot_mm", ["60", "[x, y]", "wrong kind"]),
        slip(("pivot_mm = [60, 0]", "pivot_mm = [60]"), "[60]", "body.lever.pivot_mm", ["1 of them", "[x, y]", ""]),
        slip(("[60, 0]", "[60, 0, 0]"), "[60, 0, 0]", "body.lever.pivot_mm", ["3 of them", "[x, y]", ""]),
        slip(("[60, 0]", "[60, \"0\"]"), "\"0\"", "body.lever.pivot_mm", ["\"0\"", "`0mm`", "needs its unit"]),
        slip(("[60, 0]", "[60, true]"), "[60, ", "body.lever.pivot_mm", ["true", "a number", "wrong kind"]),
        slip(("name = \"lever\"", "name = 7"), "name = 7", "body[3].name", ["7", "a string", "wrong kind"]),
        slip(("[[spring]]", "[spring]"), "[spring]", "spring", ["", "sequence", "wrong kind"]),
        slip(("angle_deg = 90", "angle_deg ="), "angle_deg =", "angle_deg", ["", "a value", "no value"]),
        slip(("angle_deg = 90", "angle_deg 90"), "angle_deg 90", "", ["", "", ""]),
    ]);
}

#[test]
fn names_of_nothing_and_names_taken() {
    let bodies = "one of `pendulum`, `pallet`, `lever`";
    check(&[
        slip(
            ("body = \"ground\"", "body = \"wall\""),
            "wall",
            "zone.bench.line.body",
            ["\"wall\"", "`lever`, `ground`", "no such body"],
        ),
        slip(
            ("body = \"lever\"\ncenter_mm = [-50", "body = \"leaver\"\ncenter_mm = [-50"),
            "leaver",
            "zone.bench.disc.body",
            ["\"leaver\"", bodies, "no such body"],
        ),
        slip(
            ("body = \"pallet\"\ntorque", "body = \"ground\"\ntorque"),
            "body = \"ground\"",
            "spring.pallet_return.body",
            ["\"ground\"", bodies, "no such body"],
        ),
        slip(
            ("hinged_on = \"pendulum\"", "hinged_on = \"wall\""),
            "wall",
            "body.pallet.hinged_on",
            ["\"wall\"", "`pendulum`", "no such body"],
        ),
        slip(
            ("name = \"pendulum\"", "name = \"pendulum\"\nhinged_on = \"pallet\""),
            "hinged_on = \"pallet\"",
            "body.pendulum.hinged_on",
            ["\"pallet\"", "`ground`", "in a circle"],
        ),
        slip(
            ("name = \"lever\"", "name = \"lever\"\nhinged_on = \"lever\""),
            "hinged_on = \"lever\"",
            "body.lever.hinged_on",
            ["\"lever\"", "`ground`", "in a circle"],
        ),
        slip(
            ("name = \"lever\"", "name = \"pallet\""),
            "name = \"pallet\"",
            "body.pallet.name",
            ["\"pallet\"", "its own", "two bodies"],
        ),
        slip(
            ("name = \"bench\"", "name = \"pallet_lever\""),
            "name = \"pallet_lever\"",
            "zone.pallet_lever.name",
            ["\"pallet_lever\"", "its own", "two zones"],
        ),
        slip(
            ("name = \"lever\"", "name = \"ground\""),
            "name = \"ground\"",
            "body.ground.name",
            ["ground", "another name", "world"],
        ),
        slip(
            ("name = \"lever\"", "name = \"The lever\""),
            "The lever",
            "body.The lever.name",
            ["The lever", "lower-case", "not a name"],
        ),
        slip(
            ("name = \"bench\"", "name = \"force\""),
            "name = \"force\"",
            "zone.force.name",
            ["force", "another name", "column"],
        ),
        slip(
            ("body = \"ground\"", "body = \"lever\""),
            "body = \"lever\"",
            "zone.bench.line.body",
            ["\"lever\"", "another body", "same body"],
        ),
    ]);
}

/// Parts of a file that the clock does not have are appended to it.
#[test]
fn faults_in_roles_screws_parts_segments_and_citations() {
    let cases: &[(&str, &str, &str, &str)] = &[
        ("[roles]\nkey = \"lever\"\n", "[roles]", "roles.key_front_mm", "missing"),
        ("[roles]\nkey = \"lever\"\nkey_front_mm = [0, 0]\n", "key = \"lever\"", "roles.key", "no [finger]"),
        ("[roles]\nhammer = \"lever\"\n", "[roles]", "roles.hammer_head_mm", "missing"),
        ("[roles]\nhammer = \"mallet\"\nhammer_head_mm = [0, 0]\n", "mallet", "roles.hammer", "no such body"),
        ("[roles]\nstring = \"lever\"\n", "string =", "roles.string", "no such zone"),
        ("[roles]\nknuckle = [\"bench\", \"bench\"]\n", "knuckle", "roles.knuckle", "twice"),
        ("[one_dof]\ntransmits = [\"cord\"]\nstops = []\n", "cord", "one_dof.transmits", "no such zone"),
        ("[one_dof]\ntransmits = []\n", "[one_dof]", "one_dof.stops", "missing"),
        ("[finger]\nstiffness_N_per_m = 0\ndamping_N_s_per_m = 1\n", "= 0", "finger.stiffness_N_per_m", "zero"),
        ("[[screw]]\nname = \"s\"\n", "[[screw]]", "screw.s.zone", "missing"),
        ("[[screw]]\nname = \"s\"\nzone = \"bench\"\n", "[[screw]]", "screw.s.side", "missing"),
        ("[[screw]]\nname = \"s\"\nzone = \"bench\"\nside = \"curve\"\n", "[[screw]]", "screw.s.direction", "missing"),
        ("[[screw]]\nname = \"s\"\nzone = \"bench\"\nside = \"left\"\n", "left", "screw.s.side", "unknown word"),
        (
            "[[screw]]\nname = \"s\"\nzone = \"bench\"\nside = \"disc\"\ndirection = [0, 1]\n",
            "[[screw]]",
            "screw.s.setting_mm",
            "missing",
        ),
        (
            "[[screw]]\nname = \"s\"\nzone = \"bench\"\nside = \"disc\"\ndirection = [0, 0]\nsetting_mm = 0\n",
            "direction",
            "screw.s.direction",
            "length",
        ),
        (
            "[[screw]]\nname = \"s\"\nzone = \"bench\"\nsetting_N_m = 0\n",
            "setting_N_m",
            "screw.s.setting_N_m",
            "does not go with",
        ),
        (
            "[[screw]]\nname = \"s\"\nspring = \"pallet_return\"\nsetting_mm = 0\n",
            "setting_mm",
            "screw.s.setting_mm",
            "does not go with",
        ),
        (
            "[[screw]]\nname = \"s\"\nspring = \"pallet_return\"\nsetting_deg = 0\n",
            "setting_deg",
            "screw.s.setting_deg",
            "does not go with",
        ),
        (
            "[[screw]]\nname = \"s\"\nzone = \"bench\"\nside = \"curve\"\nsetting_mm = 0\nsetting_deg = 0\n",
            "setting_mm",
            "screw.s.setting_mm",
            "does not go with",
        ),
        (
            "[[screw]]\nname = \"s\"\nzone = \"bench\"\nside = \"disc\"\nsetting_deg = 0\n",
            "side",
            "screw.s.side",
            "whichever way",
        ),
        ("[[screw]]\nname = \"s\"\nspring = \"coil\"\nsetting_N_m = 0\n", "coil", "screw.s.spring", "no such spring"),
        (
            "[[screw]]\nname = \"s\"\nspring = \"pallet_return\"\nzone = \"bench\"\n",
            "spring = ",
            "screw.s.spring",
            "does not go with",
        ),
        (
            "[[screw]]\nname = \"s\"\nspring = \"pallet_return\"\nsetting_N_m = 1\n",
            "setting_N_m",
            "screw.s.setting_N_m",
            "around",
        ),
        (
            "[[part]]\nname = \"p\"\nbody = \"lever\"\nmaterial = \"wood\"\noutline_mm = [[0, 0], [1, 1]]\n",
            "outline_mm",
            "part.p.outline_mm",
            "encloses",
        ),
        (
            "[[part]]\nname = \"p\"\nbody = \"lever\"\nmaterial = \"wood\"\noutline_mm = [[0, 0], [1, 1], [nan, 0]]\n",
            "outline_mm",
            "part.p.outline_mm",
            "finite",
        ),
        (
            "[[part]]\nname = \"p\"\nbody = \"lever\"\nmaterial = \"cheese\"\noutline_mm = [[0, 0], [1, 1], [1, 0]]\n",
            "cheese",
            "part.p.material",
            "unknown word",
        ),
        (
            "[[part]]\nname = \"p\"\nbody = \"moon\"\nmaterial = \"wood\"\noutline_mm = [[0, 0], [1, 1], [1, 0]]\n",
            "moon",
            "part.p.body",
            "no such body",
        ),
        (
            "[[part]]\nname = \"p\"\nbody = \"lever\"\nmaterial = \"wood\"\nsource = \"x\"\n\
             outline_mm = [[0, 0], [1, 1], [1, 0]]\n",
            "[[part]]",
            "part.p.certainty",
            "missing",
        ),
        (
            "[[zone]]\nname = \"z\"\ndisc = { body = \"lever\", center_mm = [0, 0] }\n\
             segment = { body = \"ground\", from_mm = [1, 1], to_mm = [1, 1] }\n\
             felt = { stiffness_N_per_m_r = 1, exponent = 2 }\n",
            "segment",
            "zone.z.segment.to_mm",
            "length",
        ),
        (
            "[[zone]]\nname = \"z\"\ndisc = { body = \"lever\", center_mm = [0, 0] }\n\
             other_disc = { body = \"ground\", center_mm = [1, 1] }\n\
             felt = { stiffness_N_per_m_r = 1, exponent = 2 }\n",
            "other_disc",
            "zone.z.other_disc",
            "two points",
        ),
        (
            "[[spring]]\nname = \"t\"\nbody = \"lever\"\ntorque_N_m = { value = 1, source = \"hearsay\", certainty = \"read\" }\n\
             stiffness_N_m_per_rad = 1\n",
            "hearsay",
            "spring.t.torque_N_m.source",
            "no such source",
        ),
        (
            "[[spring]]\nname = \"t\"\nbody = \"lever\"\ntorque_N_m = { value = 1, source = \"x\", certainty = \"sure\" }\n",
            "sure",
            "spring.t.torque_N_m.certainty",
            "unknown word",
        ),
        (
            "[[spring]]\nname = \"t\"\nbody = \"lever\"\ntorque_N_m = { value = 1, source = \"x\" }\n",
            "value = 1",
            "spring.t.torque_N_m.certainty",
            "missing",
        ),
        (
            "[[spring]]\nname = \"t\"\nbody = \"lever\"\n\
             torque_N_m = { value = 1, source = \"x\", certainty = \"read\", unit = \"N m\" }\n",
            "unit",
            "spring.t.torque_N_m.unit",
            "unknown key",
        ),
        (
            "[[spring]]\nname = \"t\"\nbody = \"lever\"\nstiffness_N_m_per_rad = 1\n\
             torque_N_m = { value = 1, source = \"s\", certainty = \"read\", spread = -1 }\n[sources.s]\ntitle = \"s\"\n",
            "spread",
            "spring.t.torque_N_m.spread",
            "negative",
        ),
        (
            "[[spring]]\nname = \"t\"\nbody = \"lever\"\nstiffness_N_m_per_rad = 1\n\
             torque_N_m = { value = 1, source = \"s\", certainty = \"read\", spread = 1, spread_factor = 2 }\n\
             [sources.s]\ntitle = \"s\"\n",
            "spread",
            "spring.t.torque_N_m.spread_factor",
            "found both",
        ),
        ("[sources.s]\nauthor = \"nobody\"\n", "[sources.s]", "sources.s.title", "missing"),
        ("[colours]\nwood = 1\n", "[colours]", "colours", "unknown key"),
    ];
    for (tail, line_with, key, message) in cases {
        let text = format!("{CLOCK}\n{tail}");
        let error = error_of(&text);
        let line = text.lines().enumerate().filter(|(_, line)| line.contains(line_with)).last().map(|(i, _)| i + 1);
        assert_eq!(Some(error.line), line, "line of {error}");
        assert_eq!(error.key, *key, "key of {error}");
        assert!(error.message.contains(message), "message of {error}");
    }
}

#[test]
fn more_than_the_engine_holds() {
    let body = |i: usize| {
        format!(
            "\n[[body]]\nname = \"b{i}\"\npivot_mm = [0, 0]\nmass_g = 1\ninertia_kg_m2 = 1\ncenter_of_mass_mm = [0, 0]\n"
        )
    };
    let zone = |i: usize| {
        format!(
            "\n[[zone]]\nname = \"z{i}\"\ndisc = {{ body = \"lever\", center_mm = [0, 0] }}\n\
             line = {{ body = \"ground\", point_mm = [0, 0], normal = [0, 1] }}\n\
             felt = {{ stiffness_N_per_m_r = 1, exponent = 2 }}\n"
        )
    };
    let with =
        |more: usize, table: &dyn Fn(usize) -> String| CLOCK.to_owned() + &(0..more).map(table).collect::<String>();
    assert!(Instrument::parse(&with(9, &body), "").is_ok(), "twelve bodies fit");
    let error = error_of(&with(10, &body));
    assert_eq!((error.key.as_str(), error.found.as_str()), ("body.b9", "13 bodies"));
    assert!(error.expected.contains("12") && error.line > 70);
    assert!(Instrument::parse(&with(30, &zone), "").is_ok(), "thirty-two zones fit");
    let error = error_of(&with(31, &zone));
    assert_eq!((error.key.as_str(), error.found.as_str()), ("zone.z30", "33 zones"));
}

#[test]
fn files_that_are_no_files() {
    for empty in ["", " \n\t\n"] {
        let error = error_of(empty);
        assert_eq!(error.line, 0);
        assert!(error.to_string().starts_with("clock.toml: the file is empty"), "{error}");
    }
    // A key that the whole file lacks does not belong to the file's first key.
    for lacking in ["# only a comment\n", "name = \"clock\"\n"] {
        let error = error_of(lacking);
        assert_eq!((error.line, error.key.as_str()), (1, "format"), "{error}");
    }

    let mut bytes = CLOCK.as_bytes().to_vec();
    let at = CLOCK.find("gravity").expect("gravity");
    bytes[at + 3] = 0xff;
    let error = InstrumentFile::parse_bytes(&bytes, "clock.toml").expect_err("not UTF-8");
    assert_eq!(error.line, CLOCK[..at].matches('\n').count() + 1);
    assert_eq!(error.column, 4);
    assert!(error.message.contains("UTF-8") && error.found.contains("0xff"), "{error}");
    assert_eq!(&error.text[error.span.clone()], "\u{fffd}");

    let huge = " ".repeat(MAX_FILE_BYTES + 1);
    assert!(error_of(&huge).message.contains("larger than 4 MiB"));
    assert!(
        InstrumentFile::parse_bytes(&vec![0xff; MAX_FILE_BYTES + 1], "").is_err_and(|e| e.message.contains("larger"))
    );

    let error = Instrument::load(std::path::Path::new("no/such/instrument.toml")).expect_err("no such file");
    assert!(error.to_string().starts_with("no/such/instrument.toml: cannot be read"), "{error}");

    // Nesting without end must not end the stack.
    assert!(error_of(&format!("format = {}", "[".repeat(200_000))).line == 1);
}

#[test]
fn line_ends_and_byte_order_mark_of_other_systems_read() {
    let good = Instrument::parse(CLOCK, "").expect("reads");
    assert_eq!(Instrument::parse(&CLOCK.replace('\n', "\r\n"), "").as_ref(), Ok(&good));
    assert_eq!(Instrument::parse(&format!("\u{feff}{CLOCK}"), "").as_ref(), Ok(&good));
}

/// Columns count characters, so that an editor finds the place.
#[test]
fn columns_count_characters_not_bytes() {
    let text = CLOCK.replace("name = \"lever\"", "name = \"Hébé\"");
    let error = error_of(&text);
    assert_eq!(error.column, 8);
    let text = CLOCK.replace("center_mm = [-50, -1]", "center_mm = [-50, -1] # é\nünknown = 1");
    let error = error_of(&text);
    assert!(error.line > 50, "{error}");
}

/// What is easily overlooked: a dry loss beside a viscous one needs a slip, names are checked to their last sign, a
/// bushing's own name may be taken, a key that only begins like a known one is not taken for it, a table's header that
/// is no TOML is named.
#[test]
fn slips_that_are_easily_overlooked() {
    check(&[
        slip(
            ("damping_N_s_per_m3 = 1e6", "damping_N_s_per_m3 = 1e6\ndry_loss = 0.2"),
            "dry_loss = 0.2",
            "zone.pallet_lever.felt.dry_loss",
            ["", "`dry_slip` beside it", "needs another"],
        ),
        slip(
            ("name = \"pallet\"", "name = \"1pallet\""),
            "1pallet",
            "body.1pallet.name",
            ["", "starting with a letter", "not a name"],
        ),
        slip(
            ("name = \"pallet\"", "name = \"pal-let\""),
            "pal-let",
            "body.pal-let.name",
            ["", "underscores", "not a name"],
        ),
    ]);
    // Two more: with the bushing's name for a body, and a header without its bracket.
    let bushing = CLOCK.replacen("viscous_N_m_s = 1e-6", "viscous_N_m_s = 1e-6\nbushing_N_per_m = 1e5", 1);
    let instrument = Instrument::parse(&bushing, "clock.toml").expect("a bushing reads");
    let pallet = instrument.bodies.iter().position(|body| body.is_bend).expect("the bushing's arm");
    let arm = instrument.bodies[pallet].name.clone();
    let taken = format!(
        "{bushing}\n[[spring]]\nname = \"{arm}\"\nbody = \"lever\"\nstiffness_N_m_per_rad = 1\ntorque_N_m = 0\n"
    );
    let error = error_of(&taken);
    assert!(error.message.contains(&format!("`{arm}` is taken")), "{error}");

    let guessed = error_of(&CLOCK.replacen("angle_deg", "masquerade", 1));
    assert!(!guessed.message.contains("did you mean") && guessed.expected != "`mass_g`", "{guessed}");

    let header = error_of(&CLOCK.replacen("[zone.felt]", "[zone.felt", 1));
    assert_eq!(header.key, "zone.felt", "{header}");
}
