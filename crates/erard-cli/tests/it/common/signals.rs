//! Commands under test receive signals as if they were started at a terminal.

use std::fs;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Once};

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
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
        for signal in [SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU] {
            if ignored >> (signal - 1) & 1 == 1 {
                signal_hook::flag::register(signal, Arc::new(AtomicBool::new(false)))
                    .expect("a signal that may be handled");
            }
        }
    });
}
