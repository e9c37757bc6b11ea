//! Functions for real time take no memory: an allocator counts.

use std::ptr::{null, null_mut};

use erard_c::*;

use crate::{Action, moving, pushed};

/// A note in every way of stepping, read, saved and restored.
#[test]
fn an_action_takes_none() {
    let action = Action::grand();
    let mut bytes = action.save();
    let mut numbers = [0.0; 64];
    let counted = allocation_counter::measure(|| unsafe {
        let mut r = ErardReading::default();
        let mut size = bytes.len();
        for n in 0..20_000_u32 {
            let force_n = if n / 5000 % 2 == 0 { 6.0 } else { 0.0 };
            let status = match n / 1000 % 4 {
                0 => erard_action_step_force(action.0, force_n, &raw mut r),
                1 => erard_action_step_motion(action.0, 0.004, 0.0, &raw mut r),
                2 => erard_action_step_rigid(action.0, r.key_m, 0.0, &raw mut r),
                _ => erard_action_step_free(action.0, &raw mut r),
            };
            assert!(status as i32 >= 0);
            if n % 100 == 0 {
                let input = if n % 200 == 0 { pushed(force_n) } else { moving(0.002, 0.01) };
                assert!(erard_action_advance(action.0, 1e-3, &raw const input, &raw mut r) as i32 >= 0);
                erard_action_advance(action.0, f64::NAN, &raw const input, &raw mut r);
                erard_action_read(action.0, &raw mut r);
                erard_action_angles(action.0, numbers.as_mut_ptr(), numbers.len());
                erard_action_velocities(action.0, numbers.as_mut_ptr(), numbers.len());
                erard_action_contact_forces(action.0, numbers.as_mut_ptr(), numbers.len());
                assert_eq!(erard_action_save(action.0, bytes.as_mut_ptr(), &raw mut size), ErardStatus::Ok);
                assert_eq!(erard_action_restore(action.0, bytes.as_ptr(), size), ErardStatus::Ok);
                assert_eq!(erard_action_restore(action.0, bytes.as_ptr(), size - 1), ErardStatus::Saved);
                assert!(!erard_action_body_name(action.0, 0).is_null() && !erard_status_text(-3).is_null());
            }
        }
        assert!(r.impact_count > 0);
        assert_eq!(erard_action_reset(action.0), ErardStatus::Ok);
    });
    assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{counted:?}");
}

/// Ten fingers on a keyboard.
#[test]
fn a_keyboard_takes_none() {
    let keyboard = unsafe { erard_keyboard_new(null(), 0, 50e-6, null_mut()) };
    let mut size = 0;
    unsafe { erard_keyboard_save(keyboard, null_mut(), &raw mut size) };
    let mut bytes = vec![0; size];
    let mut all = 0;
    let counted = allocation_counter::measure(|| unsafe {
        let (mut impacts, mut count, mut r) = ([ErardImpact::default(); 16], 0, ErardReading::default());
        for n in 0..8_000_u32 {
            if n % 800 == 0 {
                for finger in 0..10 {
                    let input = pushed(if n / 800 % 2 == 0 { 8.0 } else { 0.0 });
                    erard_keyboard_drive(keyboard, 1 + (n / 1600 * 10 + finger) % 88, &raw const input);
                }
            }
            erard_keyboard_step(keyboard, 1, impacts.as_mut_ptr(), 16, &raw mut count);
            all += count;
            erard_keyboard_read(keyboard, 1 + n % 88, &raw mut r);
            if n % 1000 == 999 {
                assert_eq!(erard_keyboard_save(keyboard, bytes.as_mut_ptr(), &raw mut size), ErardStatus::Ok);
                assert_eq!(erard_keyboard_restore(keyboard, bytes.as_ptr(), size), ErardStatus::Ok);
            }
        }
    });
    assert!(all >= 40, "{all} impacts");
    assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{counted:?}");
    unsafe { erard_keyboard_free(keyboard) };
}

/// Pages in WebAssembly reserve memory for the interface's structures by their sizes, which no compiler checks there:
/// too little corrupts the heap.
#[test]
fn pages_reserve_as_much_as_the_structures_take() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let says = |file: &str, text: String| {
        let found = std::fs::read_to_string(root.join(file)).unwrap();
        assert!(found.contains(&text), "{file} has no `{text}`");
    };
    let (reading, input, impact) = (size_of::<ErardReading>(), size_of::<ErardInput>(), size_of::<ErardImpact>());
    let events = size_of::<ErardEvents>();
    says("bindings/c/examples/note.mjs", format!("READING_BYTES = {reading};"));
    says("studio/src/engine/played.ts", format!("EVENTS_BYTES = {events};"));
    says("studio/src/engine/played.ts", format!("READING_BYTES = {reading};"));
    says("studio/src/engine/keys.ts", format!("INPUT_BYTES = {input};"));
    says("studio/src/engine/keys.ts", format!("IMPACT_BYTES = {impact};"));
}
