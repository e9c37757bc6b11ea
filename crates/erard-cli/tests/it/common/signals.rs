//! Commands under test receive signals as if they were started at a terminal.

use std::fs;
use std::process::Child;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Once};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU};

/// Gives every signal that the tests send its default disposition in the commands that they start.
///
/// A process inherits which signals are ignored: a shell ignores Control-C in what it runs in the background, and
/// `nohup` ignores hang-ups. A signal that has a handler here has its default disposition in a child instead. The
/// handlers do nothing, so that this process goes on ignoring what it ignored. Linux reports which signals are ignored;
/// elsewhere nothing changes.
pub fn as_at_a_terminal() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for signal in [SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU] {
            if is_in("self", "SigIgn:", signal) {
                signal_hook::flag::register(signal, Arc::new(AtomicBool::new(false)))
                    .expect("a signal that may be handled");
            }
        }
    });
}

/// Waits until a command handles Control-C: on a busy machine, a signal after a fixed time may come before its first
/// line. Linux reports which signals are handled; elsewhere this returns at once.
pub fn until_it_listens(child: &mut Child) {
    let begun = Instant::now();
    while cfg!(target_os = "linux")
        && child.try_wait().unwrap().is_none()
        && !is_in(&child.id().to_string(), "SigCgt:", SIGINT)
    {
        assert!(begun.elapsed() < Duration::from_secs(60), "it does not handle Control-C");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Whether a signal is in this mask of a process.
fn is_in(process: &str, mask: &str, signal: i32) -> bool {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix(mask));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}
