//! Command lines by chance, from the program's own description: every command that it knows, also one that was added
//! today, with inputs that are broken and outputs that are in the way. Whatever is asked, nothing may be lost.
//!
//! A seed is a command line: `ERARD_ATTACK=17 cargo test --release -p erard-cli --test it attack::one_seed -- --ignored
//! --nocapture` plays number 17 alone.

mod line;
mod world;

use std::borrow::Cow;
use std::io::Read;
use std::process::Stdio;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::common::schema::faults as schema_faults;
use line::Line;
use world::World;

/// A command that takes longer is ended as by `kill`, which must lose nothing either.
const PATIENCE: Duration = Duration::from_secs(4);
/// How long it may take to end then.
const TO_END: Duration = Duration::from_secs(20);
/// Address space of a command, KiB.
const ROOM_KIB: u32 = 3 << 20;
/// Longest message on standard error, in bytes.
const MAX_SAID: usize = 20_000;

#[test]
fn nothing_is_lost() {
    attack(0..8);
}

mod nightly {
    #[test]
    #[ignore = "nightly: another 166 command lines"]
    fn nothing_is_lost_by_more() {
        let [done, refused, ended] = super::attack(8..174);
        // Most command lines are refused at once; enough of them are not.
        assert!(done >= 10 && refused >= 10, "{done} done, {refused} refused, {ended} ended from outside");
    }

    #[test]
    #[ignore = "nightly: three thousand command lines"]
    fn nothing_is_lost_by_thousands() {
        super::attack(1000..4000);
    }

    #[test]
    #[ignore = "nightly: every option of every command, and every name of the register, with hostile values"]
    fn nothing_is_lost_by_any_value() {
        let lines = super::Line::swept();
        // Every eleventh of some twenty thousand: each option with seven of its values. ERARD_SWEEP=1 plays all.
        let step = std::env::var("ERARD_SWEEP").ok().and_then(|step| step.parse().ok()).unwrap_or(11);
        super::sweep(&lines.iter().step_by(step).collect::<Vec<_>>());
    }
}

/// Every fourth option of every command, and name of the register, once, each with another of the hostile values.
#[test]
#[ignore = "ci: a hostile value for every fourth option"]
fn nothing_is_lost_by_a_value_for_each_option() {
    let all = Line::swept();
    let mut chosen: Vec<&(String, Line)> = Vec::new();
    let groups = all.chunk_by(|a, b| a.0 == b.0).step_by(4);
    chosen.extend(groups.enumerate().map(|(n, group)| &group[7 * n % group.len()]));
    // What the program and the register hold today, and no fewer.
    assert!(chosen.len() > 75 && all.len() > 10_000, "{} options, {} lines", chosen.len(), all.len());
    sweep(&chosen);
}

#[test]
#[ignore = "ci: one seed, which ERARD_ATTACK names"]
fn one_seed() {
    let seed = std::env::var("ERARD_ATTACK").ok().and_then(|seed| seed.parse().ok()).unwrap_or(0);
    attack(seed..seed + 1);
}

/// Plays the command lines of these seeds, after which nothing may be wrong. How many were done, refused, and ended
/// from outside.
fn attack(seeds: std::ops::Range<u64>) -> [usize; 3] {
    play_all(seeds, &|seed| Cow::Owned(Line::of(seed)))
}

/// The same of lines.
fn sweep(lines: &[&(String, Line)]) -> [usize; 3] {
    play_all(0..lines.len() as u64, &|n| Cow::Borrowed(&lines[n as usize].1))
}

fn play_all<'a>(seeds: std::ops::Range<u64>, line: &(dyn Fn(u64) -> Cow<'a, Line> + Sync)) -> [usize; 3] {
    let next = AtomicU64::new(seeds.start);
    let ends = [const { AtomicUsize::new(0) }; 3];
    let threads = std::thread::available_parallelism().map_or(2, std::num::NonZero::get);
    let mut found: Vec<(u64, String)> = std::thread::scope(|scope| {
        let work = || {
            let world = World::new();
            let mut found = Vec::new();
            loop {
                let seed = next.fetch_add(1, Ordering::Relaxed);
                if seed >= seeds.end {
                    return found;
                }
                let (code, faults) = play(&world, &line(seed));
                let end = code.map_or(2, |code| usize::from(code == 2));
                ends[end].fetch_add(1, Ordering::Relaxed);
                found.extend(faults.into_iter().map(|fault| (seed, fault)));
                world.restore();
            }
        };
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap()).collect()
    });
    found.sort();
    let found: Vec<String> = found.into_iter().map(|(seed, fault)| format!("seed {seed}: {fault}")).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
    ends.map(AtomicUsize::into_inner)
}

/// What came out.
struct Ended {
    /// `None` where it was ended.
    code: Option<i32>,
    said: String,
    wrong: String,
}

/// Plays one command line: its exit code, and what is wrong with what it did.
fn play(world: &World, line: &Line) -> (Option<i32>, Vec<String>) {
    let before = world.look();
    let ended = run(world, line);
    let mut faults = Vec::new();
    if let Some(ended) = &ended {
        said_well(line, ended, &mut faults);
    } else {
        faults.push("did not end when it was asked to".to_owned());
    }
    let code = ended.and_then(|ended| ended.code);
    faults.extend(world.faults(&before, line, code));
    (code, faults.into_iter().map(|fault| format!("{}: {fault}", line.shown())).collect())
}

/// Runs a command line in its folder, with little memory; `None` where it would not end.
fn run(world: &World, line: &Line) -> Option<Ended> {
    let mut command = world.command(ROOM_KIB, &line.arguments);
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let (mut out, mut err) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let read = |from: &mut dyn Read| {
        let mut bytes = Vec::new();
        let _ = from.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    };
    std::thread::scope(|scope| {
        let (said, wrong) = (scope.spawn(move || read(&mut out)), scope.spawn(move || read(&mut err)));
        let start = Instant::now();
        let mut asked = false;
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break Some(status);
            }
            if !asked && start.elapsed() > PATIENCE {
                asked = true;
                world::end(&child);
            }
            if start.elapsed() > PATIENCE + TO_END {
                child.kill().unwrap();
                child.wait().unwrap();
                break None;
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        let (said, wrong) = (said.join().unwrap(), wrong.join().unwrap());
        // Asked to end, it may have been about to.
        status.map(|status| Ended { code: status.code().filter(|code| !(asked && *code > 2)), said, wrong })
    })
}

/// What a command says: a code of the table, no panic, and with `--json` one value of its schema.
fn said_well(line: &Line, ended: &Ended, faults: &mut Vec<String>) {
    let Some(code) = ended.code else { return };
    if !(0..=2).contains(&code) {
        faults.push(format!("exit code {code}: {}", ended.wrong));
    }
    if ended.wrong.contains("panicked") || ended.wrong.contains("overflowed its stack") {
        faults.push(format!("a panic: {}", ended.wrong));
    }
    if code != 0 && !ended.wrong.contains("error: ") {
        faults.push(format!("exit code {code} and no word why: {}", ended.wrong));
    }
    if ended.wrong.len() > MAX_SAID {
        faults.push(format!("{} bytes of messages", ended.wrong.len()));
    }
    if !line.wants_json() || line.asks_for_help() {
        return;
    }
    match serde_json::from_str::<Value>(&ended.said) {
        Err(error) => faults.push(format!("--json: exit code {code}, {error}: {:.300}", ended.said)),
        Ok(answer) => {
            let name = if code == 2 { "error" } else { line.schema(&answer) };
            let home = format!("{}/schemas/{name}.schema.json", env!("CARGO_MANIFEST_DIR"));
            let schema = std::fs::read_to_string(if answer.get("text").is_some() {
                home.replace(&format!("{name}.schema"), "text.schema")
            } else {
                home
            });
            match schema.ok().and_then(|schema| serde_json::from_str::<Value>(&schema).ok()) {
                None => faults.push(format!("--json: there is no schema {name}")),
                Some(schema) => {
                    let mut wrong = Vec::new();
                    schema_faults(&answer, &schema, "", &mut wrong);
                    faults.extend(wrong.into_iter().map(|fault| format!("--json {name}: {fault}")));
                }
            }
        }
    }
}
