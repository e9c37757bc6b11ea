//! Structs that a caller allocates carry their size: those of an older or a newer header are filled as far as both
//! sides know them, and a size that is none is refused. From plain C, and for structs that have grown.

use std::ptr::null_mut;

use crate::programs::{has, library, run};

#[path = "../../src/caller_struct.rs"]
mod caller_struct;

use caller_struct::{CallerStruct, Place, given};

const SIZES: &str = r#"
#include <erard.h>
#include <stdio.h>
#include <string.h>

#define CHECK(what) do { if (!(what)) { printf("line %d: %s\n", __LINE__, #what); return 1; } } while (0)

/* Structs of a later header. */
typedef struct { ErardReading now; double later[2]; } LaterReading;
typedef struct { ErardInput now; double later; } LaterInput;
typedef struct { ErardImpact now; double later; } LaterImpact;
typedef struct { ErardEvents now; double later; } LaterEvents;

int main(void) {
    ErardStatus status;
    ErardInstrument *instrument = erard_instrument_builtin("concert-grand", &status);
    ErardAction *action = erard_action_of_instrument(instrument, 50e-6, &status);
    ErardKeyboard *keyboard = erard_keyboard_new(NULL, 0, 50e-6, &status);
    ErardEventDetector *detector = erard_event_detector_new(instrument, &status);
    ErardStroke *stroke = erard_stroke_builtin(instrument, "mf", 0, &status);
    CHECK(instrument && action && keyboard && detector && stroke);

    ErardReading reading = {.struct_size = sizeof reading};
    ErardInput input = {.struct_size = sizeof input, .kind = ERARD_INPUT_FORCE, .force_n = 5.0};
    ErardImpact impacts[4];
    ErardEvents events;
    size_t count;
    CHECK(erard_action_step_force(action, 5.0, &reading) == 0 && reading.time_s > 0.0);
    CHECK(reading.struct_size == sizeof reading);

    const uint32_t first_input = 56;

    /* Zero, smaller than in any header, no multiple of 8, and memory that was never set. */
    const uint32_t wrong[] = {0, 8, sizeof reading - 8, sizeof reading + 4, 0xdeadbee8u};
    for (int n = 0; n < 5; n++) {
        const double before = reading.time_s;
        memset(&reading, 0x55, sizeof reading);
        memset(impacts, 0x55, sizeof impacts);
        memset(&events, 0x55, sizeof events);
        ErardReading was = reading;
        reading.struct_size = was.struct_size = wrong[n];
        CHECK(erard_action_step_force(action, 5.0, &reading) == ERARD_STATUS_STRUCT);
        CHECK(erard_action_step_motion(action, 0.0, 0.0, &reading) == ERARD_STATUS_STRUCT);
        CHECK(erard_action_step_rigid(action, 0.0, 0.0, &reading) == ERARD_STATUS_STRUCT);
        CHECK(erard_action_step_free(action, &reading) == ERARD_STATUS_STRUCT);
        CHECK(erard_action_step_input(action, &input, &reading) == ERARD_STATUS_STRUCT);
        CHECK(erard_action_step_stroke(action, stroke, &reading) == ERARD_STATUS_STRUCT);
        CHECK(strstr(erard_last_error(), "struct_size"));
        CHECK(erard_action_advance(action, 1e-3, &input, &reading) == ERARD_STATUS_STRUCT);
        CHECK(erard_action_read(action, &reading) == ERARD_STATUS_STRUCT);
        CHECK(erard_keyboard_read(keyboard, 1, &reading) == ERARD_STATUS_STRUCT);
        CHECK(!memcmp(&reading, &was, sizeof reading));
        input.struct_size = n == 2 ? first_input - 8 : n == 3 ? sizeof input + 4 : wrong[n];
        CHECK(erard_action_step_input(action, &input, NULL) == ERARD_STATUS_STRUCT);
        CHECK(erard_action_advance(action, 1e-3, &input, NULL) == ERARD_STATUS_STRUCT);
        CHECK(erard_keyboard_drive(keyboard, 40, &input) == ERARD_STATUS_STRUCT);
        input.struct_size = sizeof input;
        impacts[0].struct_size = n == 2 ? sizeof *impacts - 8 : n == 3 ? sizeof *impacts + 4 : wrong[n];
        CHECK(erard_keyboard_step(keyboard, 1, impacts, 4, &count) == ERARD_STATUS_STRUCT);
        events.struct_size = n == 2 ? sizeof events - 8 : n == 3 ? sizeof events + 4 : wrong[n];
        CHECK(erard_event_detector_read(detector, &events) == ERARD_STATUS_STRUCT);
        /* Refused without any change. */
        reading.struct_size = sizeof reading;
        CHECK(erard_action_read(action, &reading) == 0 && reading.time_s == before);
    }
    CHECK(strlen(erard_status_text(ERARD_STATUS_STRUCT)) > 10);

    /* The first header had no joints: they are stiff. */
    ErardInput hand = {
        .struct_size = sizeof hand, .kind = ERARD_INPUT_HAND, .hand_mass_kg = 0.2, .force_n = 5.0, .joints_m_per_n = -1.0
    };
    CHECK(erard_action_step_input(action, &hand, NULL) != 0);
    hand.struct_size = first_input;
    CHECK(erard_action_step_input(action, &hand, NULL) == 0);

    /* A later header's structs: what both know, and 0 in what this library does not know. */
    LaterReading later;
    memset(&later, 0x55, sizeof later);
    later.now.struct_size = sizeof later - sizeof(double);
    const double untouched = later.later[1];
    CHECK(erard_action_step_force(action, 5.0, (ErardReading *)&later) == 0);
    CHECK(erard_action_read(action, &reading) == 0);
    CHECK(later.now.struct_size == sizeof later - sizeof(double) && later.now.time_s == reading.time_s);
    CHECK(!memcmp(&later.now.key_m, &reading.key_m, sizeof reading - 16));
    CHECK(later.later[0] == 0.0 && !memcmp(&later.later[1], &untouched, sizeof untouched));
    LaterInput pressed = {input, 0.0};
    pressed.now.struct_size = sizeof pressed;
    CHECK(erard_keyboard_drive(keyboard, 40, (ErardInput *)&pressed) == 0);
    CHECK(erard_keyboard_drive(keyboard, 44, &input) == 0);
    CHECK(erard_action_step_input(action, (ErardInput *)&pressed, &reading) == 0);
    pressed.later = 1.0;
    CHECK(erard_keyboard_drive(keyboard, 40, (ErardInput *)&pressed) == ERARD_STATUS_STRUCT);
    LaterImpact three[3];
    memset(three, 0x55, sizeof three);
    three[0].now.struct_size = sizeof *three;
    CHECK(erard_keyboard_step(keyboard, 2000, (ErardImpact *)three, 3, &count) == 0 && count == 2);
    CHECK((three[0].now.key == 40 && three[1].now.key == 44) || (three[0].now.key == 44 && three[1].now.key == 40));
    for (int n = 0; n < 2; n++) {
        CHECK(three[n].now.struct_size == sizeof *three && three[n].now.hammer_speed_m_per_s > 0.1 && three[n].later == 0.0);
    }
    CHECK(three[2].now.key == 0x55555555);
    LaterEvents seen;
    memset(&seen, 0x55, sizeof seen);
    seen.now.struct_size = sizeof seen;
    events.struct_size = sizeof events;
    CHECK(erard_event_detector_read(detector, (ErardEvents *)&seen) == 0 && seen.later == 0.0);
    CHECK(erard_event_detector_read(detector, &events) == 0);
    CHECK(!memcmp(&seen.now.key_start_s, &events.key_start_s, sizeof events - 8));
    /* Without room for impacts, and without a reading, there is no size. */
    CHECK(erard_keyboard_step(keyboard, 1, NULL, 0, &count) == 0 && erard_action_step_free(action, NULL) == 0);

    erard_stroke_free(stroke);
    erard_event_detector_free(detector);
    erard_keyboard_free(keyboard);
    erard_action_free(action);
    erard_instrument_free(instrument);
    puts("all sizes");
    return 0;
}
"#;

#[test]
fn structs_carry_their_size() {
    if !has("cc") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (source, program) = (folder.path().join("sizes.c"), folder.path().join("sizes"));
    std::fs::write(&source, SIZES).expect("written");
    let mut cc = std::process::Command::new("cc");
    cc.args(["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-pedantic", "-I"]);
    cc.arg(format!("{}/include", env!("CARGO_MANIFEST_DIR"))).arg(&source).arg(library("liberard_c.a"));
    run(cc.args(["-lpthread", "-ldl", "-lm", "-o"]).arg(&program));
    assert_eq!(run(&mut std::process::Command::new(program)).trim(), "all sizes");
}

/// A struct in its first header.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct First {
    struct_size: u32,
    count: u32,
    a: f64,
}

/// The same struct in a header that came later.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Grown {
    struct_size: u32,
    count: u32,
    a: f64,
    b: f64,
}

// SAFETY: `repr(C)` structs of numbers without padding, whose first field is their size.
unsafe impl CallerStruct for Grown {
    const FIRST_BYTES: usize = size_of::<First>();
}

/// A library whose structs have grown serves a program that was built with the first header.
#[test]
fn a_grown_struct_serves_the_first_header() {
    let old = First { struct_size: size_of::<First>() as u32, count: 0, a: 0.0 };
    let beyond = First { struct_size: 7, count: 7, a: 7.0 };
    let mut memory = [old, old, beyond];
    let new = Grown { struct_size: size_of::<Grown>() as u32, count: 3, a: 1.5, b: 2.5 };
    assert_eq!(Grown::zeroed(), Grown { count: 0, a: 0.0, b: 0.0, ..new });
    let place = unsafe { Place::<Grown>::new(memory.as_mut_ptr().cast()) }.unwrap().unwrap();
    unsafe {
        place.write(0, &new);
        place.write(1, &Grown { a: 4.5, ..new });
    }
    assert_eq!(memory, [First { count: 3, a: 1.5, ..old }, First { count: 3, a: 4.5, ..old }, beyond]);
    let read = unsafe { given::<Grown>((&raw const memory[0]).cast()) }.unwrap();
    assert_eq!(read, Grown { b: 0.0, ..new }, "what the first header lacks is 0");
    for bytes in [0, 8, 20, 4104, u32::MAX] {
        memory[0].struct_size = bytes;
        assert!(unsafe { Place::<Grown>::new(memory.as_mut_ptr().cast()) }.is_err(), "{bytes}");
        assert!(unsafe { given::<Grown>((&raw const memory[0]).cast()) }.is_err(), "{bytes}");
    }
    assert!(matches!(unsafe { Place::<Grown>::new(null_mut()) }, Ok(None)));
}
