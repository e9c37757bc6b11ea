//! The note on derivatives: all numbers of the concert grand at pp, mf and ff, compared with differences in
//! converged steps.
//!
//! `.ci/regenerate derivatives` writes it; `cargo run --release -p erard-workshop --example derivatives -- --all`
//! prints every row with its numbers instead, `-- pp hammer_contact_s jack_position` one number's slopes over many
//! windows and steps.

mod compare;

use std::error::Error;
use std::fmt::Write;

use compare::{
    Closely, FIRST, First, LEVELS, Level, OF, Row, TRAP_S, TRAPPED, Verdict, closely, first_cases, level, trap,
};
use erard::Instrument;

const PAGE: &str = include_str!("page.md");

fn main() -> Result<(), Box<dyn Error>> {
    let instrument = Instrument::builtin("concert-grand")?;
    let asked: Vec<String> = std::env::args().skip(1).collect();
    if let [level, of, by] = asked.as_slice() {
        print_closely(&closely(&instrument, level, of, by));
        return Ok(());
    }
    let first = first_cases();
    let levels: Vec<Level> = LEVELS.into_iter().map(|name| level(&instrument, name)).collect();
    if asked.iter().any(|flag| flag == "--all") {
        levels.iter().for_each(list);
        return Ok(());
    }
    let count = levels[0].rows.len() / OF.len();
    // Of this machine now: the page holds times of an earlier run.
    for Level { name, gradient_s, differences_s, .. } in &levels {
        eprintln!("{name}: derivatives {gradient_s:.1} s, central differences in lanes {differences_s:.1} s");
    }
    let page = PAGE
        .replace("{first}", &first_table(&first)?)
        .replace("{trap}", &trap_table(&trap(&instrument))?)
        .replace("{count}", &count.to_string())
        .replace("{table}", &table(&levels, count)?)
        .replace("{summary}", &summary(&levels)?)
        .replace("{listed}", &listed(&levels)?);
    print!("{page}");
    Ok(())
}

fn list(level: &Level) {
    for row in &level.rows {
        let Row { of, by, derivative, shorter, differences, scatter, sides: [below, above], window, verdict, .. } = row;
        println!(
            "{:3} {of:22} {by:30} {derivative:10.3e} {shorter:10.3e} | {differences:10.3e} +- {scatter:8.1e} \
             [{below:10.3e} {above:10.3e}] {window:4} {verdict:?}",
            level.name
        );
    }
}

fn print_closely(all: &[Closely]) {
    for Closely { step_s, derivative, differences } in all {
        println!("steps of {} us: derivative {derivative:.4e}", 1e6 * step_s);
        for (window, [below, above]) in differences {
            println!("  +- {window:6}: {below:11.4e} {above:11.4e}, middle {:11.4e}", 0.5 * (below + above));
        }
    }
}

fn first_table(first: &[First]) -> Result<String, std::fmt::Error> {
    let mut text = "| friction of | moves: derivative | differences | held: derivative | differences |\n".to_owned();
    writeln!(text, "|---|---|---|---|---|")?;
    for (name, one) in FIRST.iter().zip(first) {
        let [[a, b], [c, d]] = one;
        writeln!(text, "| `{name}` | {a:.3e} | {b:.3e} | {c:.3e} | {d:.3e} |")?;
    }
    Ok(text.trim_end().to_owned())
}

/// Table of derivatives and differences for several step lengths.
fn trap_table(found: &[[[f64; 2]; 4]; 4]) -> Result<String, std::fmt::Error> {
    let mut text = "| per usual change of |".to_owned();
    for step_s in TRAP_S {
        write!(text, " {} us: derivative | differences |", 1e6 * step_s)?;
    }
    text += "\n|---|";
    text += &"---|".repeat(2 * TRAP_S.len());
    for (name, one) in TRAPPED.iter().zip(found) {
        write!(text, "\n| `{name}` |")?;
        for [derivative, differences] in one {
            write!(text, " {} | {} |", micro(*derivative), micro(*differences))?;
        }
    }
    Ok(text)
}

/// Table of hammer speed.
fn table(levels: &[Level], count: usize) -> Result<String, std::fmt::Error> {
    let mut text = "|  |".to_owned();
    for one in levels {
        write!(text, " {} |  |  |", one.name)?;
    }
    text += "\n|---|";
    text += &"---|".repeat(3 * levels.len());
    text.push('\n');
    for k in 0..count {
        write!(text, "| `{}` |", levels[0].rows[k].by)?;
        for one in levels {
            let row = &one.rows[k];
            if row.verdict == Verdict::NoEffect {
                text += " 0 | 0 | = |";
                continue;
            }
            let same = match row.verdict {
                Verdict::Within | Verdict::Scatter => " =",
                _ => "",
            };
            write!(text, " {} | {} | {}%{same} |", micro(row.derivative), micro(row.differences), share(row.apart()))?;
        }
        text.push('\n');
    }
    Ok(text.trim_end().to_owned())
}

fn micro(x: f64) -> String {
    if x.is_nan() {
        return "refused".to_owned();
    }
    let x = 1e6 * x;
    if x.abs() < 100.0 { format!("{x:.1}") } else { format!("{x:.0}") }
}

fn share(x: f64) -> String {
    if x.is_nan() { "-".to_owned() } else { format!("{:.1} ", 100.0 * x) }
}

fn summary(levels: &[Level]) -> Result<String, std::fmt::Error> {
    let mut text =
        "| result | level | within 2 % | within the scatter | listed | no effect |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for of in OF {
        for one in levels {
            let count = |verdicts: &[Verdict]| {
                one.rows.iter().filter(|row| row.of == of && verdicts.contains(&row.verdict)).count()
            };
            let [within, scatter] = [Verdict::Within, Verdict::Scatter].map(|verdict| count(&[verdict]));
            let (listed, none) = (count(&[Verdict::Apart, Verdict::Refused]), count(&[Verdict::NoEffect]));
            writeln!(text, "| `{of}` | {} | {within} | {scatter} | {listed} | {none} |", one.name)?;
        }
    }
    Ok(text.trim_end().to_owned())
}

fn listed(levels: &[Level]) -> Result<String, std::fmt::Error> {
    let mut text =
        "| level | result | number | apart | scatter | shorter steps | below to above | because |\n".to_owned();
    writeln!(text, "|---|---|---|---|---|---|---|---|")?;
    for one in levels {
        for row in one.rows.iter().filter(|row| matches!(row.verdict, Verdict::Apart | Verdict::Refused)) {
            let [below, above] = row.sides;
            let of = |x: f64| share(x / row.differences.abs());
            writeln!(
                text,
                "{} {}%| {}%| {}%| {}%| {} |",
                compare::line(one.name, row),
                share(row.apart()),
                of(row.scatter),
                of((row.derivative - row.shorter).abs()),
                of((above - below).abs()),
                row.reason()
            )?;
        }
    }
    Ok(text.trim_end().to_owned())
}
