//! Work that the papers leave for later, and its state here. What is here is looked up: in the built-in instruments, in
//! the numbers that a file may hold, in the recordings of the package.

use erard::instrument::{Certainty, FileNumber, Instrument, InstrumentFile};
use erard::stroke::{Columns, Recording, Role};

use super::{Progress, ReproduceError, Section, Table, train};

/// Names of the built-in instruments that have something.
fn instruments_with(has: fn(&Instrument) -> bool) -> Vec<&'static str> {
    Instrument::builtin_names().filter(|name| Instrument::builtin(name).is_ok_and(|own| has(&own))).collect()
}

/// Parameters of an instrument file that are estimates, and all that cite a source.
fn estimates() -> [usize; 2] {
    let text = Instrument::builtin_text("concert-grand").unwrap_or_default();
    let Ok(file) = InstrumentFile::parse(text, "concert-grand") else { return [0; 2] };
    let cited: Vec<Certainty> =
        file.provenance.numbers.iter().filter_map(|number| Some(number.citation.as_ref()?.certainty)).collect();
    [cited.iter().filter(|certainty| **certainty == Certainty::Estimate).count(), cited.len()]
}

/// Recorded strokes of the package with a measured force, and all.
fn with_force() -> [usize; 2] {
    let has_force = |text: &str| {
        let recording = Recording::read(text.as_bytes(), "", &Columns::default());
        recording.is_ok_and(|recording| recording.channel(Role::Force).is_some())
    };
    [train::STROKES.iter().filter(|(_, text)| has_force(text)).count(), train::STROKES.len()]
}

/// Which of these keys an instrument file may hold.
fn keys(wanted: &[&'static str]) -> Vec<&'static str> {
    wanted.iter().copied().filter(|key| FileNumber::all().any(|number| number.key == *key)).collect()
}

/// `yes`, or `no` where nothing is found.
fn here(found: bool, yes: &str) -> String {
    if found { yes.to_owned() } else { "no".to_owned() }
}

pub(super) fn section(_: &Instrument, _: &mut Progress) -> Result<Section, ReproduceError> {
    let mut table = Table::new("Honestly", &["what", "whose wish", "here", "how, or what is missing"]);
    let mut row =
        |what: &str, whose: &str, here: String, how: String| table.row([what.into(), whose.into(), here, how]);
    row(
        "run time below real time",
        "[T13]",
        "yes".into(),
        "`erard-reproduce --only paper2-run-time`; the papers' was 20 times slower than real time".into(),
    );
    row("true stick at rest and in the check", "[T12]", "yes".into(), "`erard-reproduce --only paper2-rest`".into());
    row(
        "impacts, sliding and planar-free joints, closed loops, moving surfaces (all of the inclusion set K)",
        "[T12], [T13]",
        "engine only".into(),
        "a rigid multibody step of its own with the textbook problems 9 to 14 and 16 to 21; no instrument file uses it"
            .into(),
    );
    row(
        "a six-body model beside the three levers of the kinematic model",
        "[H]",
        "yes".into(),
        "one instrument file gives both; a slow press agrees with the geometry".into(),
    );
    row(
        "comparison with measured motion",
        "[T12], [T13]",
        here(!train::STROKES.is_empty(), "yes"),
        "recordings of key and hammer of one grand: `erard-reproduce --only released-key,train-felts,lying-key`".into(),
    );
    let [forces, strokes] = with_force();
    row(
        "comparison with measured force",
        "[T12], [T13]",
        if forces > 0 { "yes" } else { "tool only" }.into(),
        format!(
            "`erard compare FILE`. {forces} of {strokes} recorded strokes of the package have a measured force. Without \
             one these claims cannot fail on a recording: force-driven against motion-driven, the force's fine \
             structure, and what one degree of freedom misses of it"
        ),
    );
    let [estimated, cited] = estimates();
    row(
        "identified parameters of one real action",
        "[T13]",
        here(2 * estimated < cited, "mostly"),
        format!("{estimated} of {cited} numbers of the instrument file are estimates, and say so"),
    );
    let bends = instruments_with(Instrument::has_bends);
    row(
        "bending of the hammer shank and of the key",
        "[H]",
        here(!bends.is_empty(), "yes"),
        format!(
            "`erard-reproduce --only what-gives`: keys and shanks are two pieces each, on hinges, in {}",
            bends.join(", ")
        ),
    );
    let strings = instruments_with(Instrument::has_yielding_strings);
    let how = if strings.is_empty() {
        "the string is a felt on the ground".to_owned()
    } else {
        format!("modal strings, in {}; in the other built-in instruments the string is rigid", strings.join(", "))
    };
    row("the string's own motion", "[T13]", here(!strings.is_empty(), "as an option"), how);
    row(
        "the finger as part of a hand and an arm",
        "[T13]",
        "as an option".into(),
        "`press --hand`: a mass that muscle moves behind the fingertip; the built-in strokes were played by it".into(),
    );
    let options = keys(&["dry_loss", "relaxed", "bushing_N_per_m", "static_friction_ratio", "dwell_s"]);
    row(
        "felt with hysteresis, bushings, friction that depends on how long it has rested",
        "[H]",
        here(!options.is_empty(), "as options"),
        format!("{} in instrument files; `erard-reproduce --only felt-losses,bushings`", options.join(", ")),
    );
    row("wear, humidity", "-", "no".into(), String::new());
    Ok(Section { tables: vec![table], ..Section::default() })
}
