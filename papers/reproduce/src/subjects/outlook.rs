//! Work that the papers leave for later, and its state here.

use super::{Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;

pub(super) fn section(_: &Instrument, _: &mut Progress) -> Result<Section, ReproduceError> {
    let mut table = Table::new("Honestly", &["what", "whose wish", "here", "how, or what is missing"]);
    let mut row =
        |what: &str, whose: &str, here: &str, how: &str| table.row([what, whose, here, how].map(str::to_owned));
    row(
        "run time below real time",
        "[T13]",
        "yes",
        "`erard-reproduce --only paper2-run-time`; the papers' was 20 times slower than real time",
    );
    row("true stick at rest and in the check", "[T12]", "yes", "`erard-reproduce --only paper2-rest`");
    row(
        "impacts, sliding and planar-free joints, closed loops, moving surfaces (all of the inclusion set K)",
        "[T12], [T13]",
        "engine only",
        "a rigid multibody step of its own with the textbook problems 9 to 14 and 16 to 21; no instrument file uses it",
    );
    row(
        "a six-body model beside the three levers of the kinematic model",
        "[H]",
        "yes",
        "one instrument file gives both; a slow press agrees with the geometry",
    );
    row(
        "comparison with measured motion",
        "[T12], [T13]",
        "yes",
        "recordings of key and hammer of one grand: `erard-reproduce --only released-key,train-felts,lying-key`",
    );
    row(
        "comparison with measured force",
        "[T12], [T13]",
        "tool only",
        "`erard compare FILE`. No recording in the package has a measured force, so that these claims cannot fail on one: \
         force-driven against motion-driven, the force's fine structure, and what one degree of freedom misses of it",
    );
    row(
        "identified parameters of one real action",
        "[T13]",
        "no",
        "most numbers of the instrument file are estimates, and say so",
    );
    row(
        "bending of the hammer shank and of the key",
        "[H]",
        "yes",
        "`erard-reproduce --only what-gives`: the built-in instruments' keys and shanks are two pieces each, on hinges",
    );
    row("the string's own motion", "[T13]", "no", "the string is a felt on the ground");
    row(
        "the finger as part of a hand and an arm",
        "[T13]",
        "as an option",
        "`press --hand`: a mass that muscle moves behind the fingertip; the built-in strokes were played by it",
    );
    row(
        "felt with hysteresis, bushings, friction that depends on how long it has rested",
        "[H]",
        "as options",
        "`dry_loss`, `relaxed`, `bushing_N_per_m`, `static_friction_ratio` in instrument files; `erard-reproduce --only felt-losses,bushings`",
    );
    row("wear, humidity", "-", "no", "");
    Ok(Section { tables: vec![table], ..Section::default() })
}
