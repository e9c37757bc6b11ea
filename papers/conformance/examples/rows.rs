//! Prints all rows: `cargo run --release -p moreau-conformance --example rows [NUMBER ...]`.

use moreau_conformance::Expected;

fn main() {
    let wanted: Vec<u32> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    for problem in moreau_conformance::problems() {
        if !wanted.is_empty() && !wanted.contains(&problem.number) {
            continue;
        }
        println!("{}. {}", problem.number, problem.name);
        for row in (problem.rows)() {
            let unit = if row.unit.is_empty() { String::new() } else { format!(" [{}]", row.unit) };
            let expected = match row.expected {
                Expected::Near { value, tolerance } => {
                    format!("{value:>19.12}, off by {:7.1e} of {tolerance:7.1e}", (row.ours - value).abs())
                }
                Expected::AtMost(bound) => format!("at most {bound}"),
                Expected::AtLeast(bound) => format!("at least {bound}"),
            };
            let holds = if row.holds() { "holds" } else { "FAILS" };
            println!("  {:76} {:>19.12}   {expected:50} {holds}", format!("{}{unit}", row.quantity), row.ours);
        }
    }
}
