//! The note on the pose of rest: how well one blow finds it, what it costs, and what it changes on every line of the
//! sheet of every built-in instrument.
//!
//! `.ci/regenerate rest` writes it.

use std::error::Error;
use std::fmt::Write;

use erard::keyboard::Keyboard;
use erard::player::{AtRest, BLOW_N, HELD_S, Input, LET_UP_S, RestKind, RestPose};
use erard::run::simulate_at_rest;
use erard::{Instrument, Settings, Setup};
use erard_workshop::measure::measure;
use erard_workshop::measure::norms::page_lines;
use erard_workshop::measure::weights::on_the_scale;

const PAGE: &str = include_str!("page.md");
const STEP_S: f64 = 50e-6;
/// Times of a release, s, and forces of a blow, N: the first one counts.
const RELEASES_S: [f64; 6] = [0.001, LET_UP_S, 0.1, 0.2, 0.3, 0.5];
const FORCES_N: [f64; 3] = [BLOW_N, 2.5, 8.0];
/// Settings of the capstan, mm, from the file's.
const CAPSTAN_MM: [f64; 9] = [-0.2, -0.15, -0.1, -0.05, 0.0, 0.05, 0.1, 0.15, 0.2];
/// Force of the next blow, N: about mf.
const NEXT_N: f64 = 5.0;

fn main() -> Result<(), Box<dyn Error>> {
    let builtin: Vec<Instrument> = Instrument::builtin_names().map(Instrument::builtin).collect::<Result<_, _>>()?;
    let keyboard = Keyboard::builtin("concert-grand")?;
    let keys: Vec<Instrument> = [1, 20, 60, 88].into_iter().map(|key| keyboard.key(key)).collect::<Result<_, _>>()?;
    let all: Vec<&Instrument> = builtin.iter().chain(&keys).collect();
    let grand = Instrument::builtin("concert-grand")?;
    let page = PAGE
        .replace("{blow}", &format!("{BLOW_N}"))
        .replace("{held}", &format!("{}", 1e3 * HELD_S))
        .replace("{up}", &format!("{}", 1e3 * LET_UP_S))
        .replace("{again}", &again(&all)?)
        .replace("{releases}", &releases(&all)?)
        .replace("{capstan}", &capstan(&grand)?)
        .replace("{geometry}", &format!("{:.2}", geometry_mm(&grand)?))
        .replace("{next}", &next(&all)?)
        .replace("{sheets}", &sheets(&builtin)?);
    print!("{page}");
    Ok(())
}

fn go(_: f64) -> bool {
    true
}

/// Distance of hammer and string, mm.
fn blow_mm(rest: &RestPose) -> Result<f64, Box<dyn Error>> {
    let string = rest.instrument().roles.string.ok_or("no string")?;
    Ok(-1e3 * rest.action(Settings::new(STEP_S))?.compression(string)?)
}

/// The blow as drawn, and after one blow and more.
fn again(all: &[&Instrument]) -> Result<String, Box<dyn Error>> {
    let mut text = "| instrument | as drawn | as played | lower by | 2nd blow | 3rd | 4th |\n".to_owned();
    text += "|---|---|---|---|---|---|---|";
    for instrument in all {
        let drawn = blow_mm(&RestPose::of(instrument, RestKind::AsDrawn, &mut go)?)?;
        let mut rest = RestPose::of(instrument, RestKind::AsPlayed, &mut go)?;
        let played = blow_mm(&rest)?;
        write!(text, "\n| {} | {drawn:.3} mm | {played:.3} mm | {:.3} mm |", instrument.name, played - drawn)?;
        for _ in 2..=4 {
            rest = rest.played_again(&mut go)?;
            write!(text, " {:+.2} um |", 1e3 * (blow_mm(&rest)? - played))?;
        }
    }
    Ok(text)
}

/// How steadily the blow follows the capstan, and how much the force of the blow decides, over the time of the release.
fn releases(all: &[&Instrument]) -> Result<String, Box<dyn Error>> {
    let mut text = "| instrument |".to_owned();
    for up_s in RELEASES_S {
        write!(text, " {:.0} ms |", 1e3 * up_s)?;
    }
    text += "\n|---|";
    text += &"---|".repeat(RELEASES_S.len());
    for instrument in all {
        let (screw, string) = capstan_and_string(instrument)?;
        write!(text, "\n| {} |", instrument.name)?;
        for up_s in RELEASES_S {
            let (mut blows, mut by_force): (Vec<f64>, f64) = (Vec::new(), 0.0);
            for by_mm in CAPSTAN_MM {
                let turned = turned(instrument, screw, by_mm)?;
                let drawn = RestPose::of(&turned, RestKind::AsDrawn, &mut go)?;
                let mut found = [0.0; FORCES_N.len()];
                for (found, force_n) in found.iter_mut().zip(FORCES_N) {
                    let mut action = drawn.action(Settings::new(STEP_S))?;
                    let mut steps = 0..((HELD_S + up_s) / STEP_S).round() as u64;
                    action.play(&mut go, &mut |_| {
                        let t = (steps.next()? as f64 + 0.5) * STEP_S;
                        Some(Input::Force(force_n * (1.0 - (t - HELD_S) / up_s).clamp(0.0, 1.0)))
                    })?;
                    action.settle(&turned, Input::Free, &mut go)?;
                    *found = -1e3 * action.compression(string)?;
                }
                blows.push(found[0]);
                by_force = found.iter().fold(by_force, |most, blow| most.max((blow - found[0]).abs()));
            }
            let slopes = || blows.windows(2).map(|two| two[0] - two[1]);
            let (least, most) = (slopes().fold(f64::INFINITY, f64::min), slopes().fold(f64::NEG_INFINITY, f64::max));
            write!(text, " {least:.2} to {most:.2}; {by_force:.2} |")?;
        }
    }
    Ok(text)
}

/// The capstan's screw, and the zone between hammer and string.
fn capstan_and_string(instrument: &Instrument) -> Result<(usize, usize), Box<dyn Error>> {
    let screw = instrument.screw("capstan_height").ok_or("no capstan")?;
    Ok((screw, instrument.roles.string.ok_or("no string")?))
}

/// The instrument with a screw turned by so much, mm.
fn turned(instrument: &Instrument, screw: usize, by_mm: f64) -> Result<Instrument, Box<dyn Error>> {
    let mut turned = instrument.clone();
    let setting = instrument.screws[screw].setting + 1e-3 * by_mm;
    if turned.turn(screw, setting) { Ok(turned) } else { Err("the screw does not turn".into()) }
}

/// The blow over the capstan's screw, as drawn and as played.
fn capstan(instrument: &Instrument) -> Result<String, Box<dyn Error>> {
    let (screw, _) = capstan_and_string(instrument)?;
    let mut text = "| capstan | as drawn | change | as played | change |\n|---|---|---|---|---|".to_owned();
    let mut before: Option<[f64; 2]> = None;
    for by_mm in CAPSTAN_MM {
        let turned = turned(instrument, screw, by_mm)?;
        let mut now = [0.0; 2];
        for (now, kind) in now.iter_mut().zip([RestKind::AsDrawn, RestKind::AsPlayed]) {
            *now = blow_mm(&RestPose::of(&turned, kind, &mut go)?)?;
        }
        write!(text, "\n| {by_mm:+.2} mm |")?;
        for (k, now) in now.iter().enumerate() {
            let change = before.map_or(String::new(), |before| format!("{:+.3} mm", now - before[k]));
            write!(text, " {now:.3} mm | {change} |")?;
        }
        before = Some(now);
    }
    Ok(text)
}

/// What the levers make of a turn of the capstan, mm: rise of the hammer's strike point.
fn geometry_mm(instrument: &Instrument) -> Result<f64, Box<dyn Error>> {
    let (scale, ratio) = on_the_scale(instrument, 6e-3, [1e-3, 5e-3])?;
    Ok((CAPSTAN_MM[1] - CAPSTAN_MM[0]) * ratio.at_rest / scale.key_ratio)
}

/// Hammer speed of the next blow.
fn next(all: &[&Instrument]) -> Result<String, Box<dyn Error>> {
    let mut text = "| instrument | from as drawn | from as played | change |\n|---|---|---|---|".to_owned();
    for instrument in all {
        let mut speeds = [0.0; 2];
        for (speed, kind) in speeds.iter_mut().zip([RestKind::AsDrawn, RestKind::AsPlayed]) {
            let rest = RestPose::of(instrument, kind, &mut go)?;
            let setup = Setup { ledger: false, settings: Settings::new(STEP_S), ..Setup::new(0.2) };
            let run = simulate_at_rest(&rest, &|_| Input::Force(NEXT_N), &setup, &mut go)?;
            *speed = run.events.hammer_speed_m_per_s().ok_or("silent")?;
        }
        let change = 100.0 * (speeds[1] / speeds[0] - 1.0);
        write!(text, "\n| {} | {:.4} m/s | {:.4} m/s | {change:+.2} % |", instrument.name, speeds[0], speeds[1])?;
    }
    Ok(text)
}

/// Every line of every sheet, before and after.
fn sheets(all: &[Instrument]) -> Result<String, Box<dyn Error>> {
    let mut text = "| line |".to_owned();
    let mut sheets = Vec::new();
    for instrument in all {
        write!(text, " {} |", instrument.name)?;
        let drawn = RestPose::of(instrument, RestKind::AsDrawn, &mut go)?;
        sheets.push([measure(&drawn, &mut go)?, measure(instrument, &mut go)?]);
    }
    text += "\n|---|";
    text += &"---|".repeat(all.len());
    for line in page_lines() {
        let unit = if line.unit.is_empty() { String::new() } else { format!(", {}", line.unit) };
        write!(text, "\n| {}{unit} |", line.label)?;
        for pair in &sheets {
            let [before, after] = [&pair[0], &pair[1]].map(|sheet| {
                let mark = if line.is_out(sheet) { " !" } else { "" };
                let value =
                    (line.value)(sheet).map_or("-".to_owned(), |value| format!("{value:.*}", line.decimals + 1));
                format!("{value}{mark}")
            });
            if before == after {
                write!(text, " {before} |")?;
            } else {
                write!(text, " {before} → **{after}** |")?;
            }
        }
    }
    Ok(text)
}
