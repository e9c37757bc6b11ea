//! Printed closure equations: plain text and LaTeX, with the user's names.

use std::fmt;

use super::closure::{Closure, Magnitude, Term};
use super::description::{BodyId, JointKind, Linkage};
use super::direction::Direction;

/// Component of a vector closure equation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// World x.
    X,
    /// World y.
    Y,
}

/// Sine or cosine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trig {
    /// Cosine.
    Cos,
    /// Sine.
    Sin,
}

/// Printed term: `coefficient · magnitude · trig(argument)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EquationTerm {
    /// Signed integer, nearly always ±1.
    pub coefficient: i32,
    /// The user's symbol, or the value of a constant without a name.
    pub magnitude: String,
    /// Sine or cosine; `None` for a constant along an axis of the ground.
    pub trig: Option<Trig>,
    /// Angle as a sum of symbols with integer factors. Empty without `trig`.
    pub argument: Vec<(i32, String)>,
}

/// Scalar closure equation, `terms = 0`. `Display` prints plain text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Equation {
    /// Number, from 1: loop 1 has equations 1 (x) and 2 (y), and so on.
    pub number: usize,
    /// Number of the loop, from 1.
    pub circuit: usize,
    /// Component of the loop's vector equation.
    pub axis: Axis,
    /// Terms in printing order.
    pub terms: Vec<EquationTerm>,
}

pub(crate) fn equations(linkage: &Linkage, leaders: &Symbols, closures: &[Closure]) -> Vec<Equation> {
    let mut equations = Vec::with_capacity(2 * closures.len());
    for (i, closure) in closures.iter().enumerate() {
        for axis in [Axis::X, Axis::Y] {
            equations.push(Equation {
                number: equations.len() + 1,
                circuit: i + 1,
                axis,
                terms: (closure.terms.iter()).filter_map(|term| component(linkage, leaders, term, axis)).collect(),
            });
        }
    }
    equations
}

/// The symbols of the bodies' angles, by body.
pub(crate) struct Symbols(pub Vec<String>);

fn component(linkage: &Linkage, symbols: &Symbols, term: &Term, axis: Axis) -> Option<EquationTerm> {
    let argument = argument(linkage, symbols, term.frame, &term.direction);
    // (cos, sin) of an angle, and of that angle plus a quarter turn.
    let (sign, trig) = match (axis, term.direction.quarters) {
        (Axis::X, 0) => (1, Trig::Cos),
        (Axis::Y, 0) => (1, Trig::Sin),
        (Axis::X, _) => (-1, Trig::Sin),
        (Axis::Y, _) => (1, Trig::Cos),
    };
    if argument.is_empty() && trig == Trig::Sin {
        return None;
    }
    let (sign, magnitude) = match term.magnitude {
        Magnitude::Length(id) => {
            let constant = &linkage.lengths[id.0];
            match &constant.name {
                Some(name) => (sign, name.clone()),
                None if constant.value < 0.0 => (-sign, (-constant.value).to_string()),
                None => (sign, constant.value.to_string()),
            }
        }
        Magnitude::Sliding(joint) => match &linkage.joints[joint.0].kind {
            JointKind::Prismatic { symbol, .. } => (sign, symbol.clone()),
            JointKind::Revolute => unreachable!("only prismatic joints slide"),
        },
    };
    Some(EquationTerm {
        coefficient: sign * term.coefficient,
        magnitude,
        trig: (!argument.is_empty()).then_some(trig),
        argument,
    })
}

fn argument(linkage: &Linkage, symbols: &Symbols, frame: BodyId, direction: &Direction) -> Vec<(i32, String)> {
    let body = (frame.0 > 0).then(|| (1, symbols.0[frame.0].clone()));
    let named = direction.named.iter().map(|&(id, factor)| {
        let name = linkage.angles[id.0].name.clone().unwrap_or_default();
        (factor, name)
    });
    body.into_iter().chain(named).collect()
}

/// Writes `a - 2 b + c` with each symbol passed through `show`.
fn write_sum<'a>(out: &mut String, parts: impl Iterator<Item = (i32, &'a dyn Fn(&mut String))>) {
    for (i, (factor, show)) in parts.enumerate() {
        out.push_str(match (i, factor < 0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        });
        if factor.abs() != 1 {
            out.push_str(&format!("{} ", factor.abs()));
        }
        show(out);
    }
}

/// How one notation writes its parts.
struct Notation {
    symbol: fn(&str) -> String,
    cos: &'static str,
    sin: &'static str,
    open: &'static str,
    close: &'static str,
}

const TEXT: Notation = Notation { symbol: |name| name.to_owned(), cos: "cos", sin: "sin", open: "(", close: ")" };

const LATEX: Notation =
    Notation { symbol: latex_symbol, cos: r"\cos", sin: r"\sin", open: r"\left(", close: r"\right)" };

impl EquationTerm {
    fn write(&self, out: &mut String, notation: &Notation) {
        out.push_str(&(notation.symbol)(&self.magnitude));
        let Some(trig) = self.trig else { return };
        out.push(' ');
        out.push_str(match trig {
            Trig::Cos => notation.cos,
            Trig::Sin => notation.sin,
        });
        let mut inside = String::new();
        let shows: Vec<_> = (self.argument.iter())
            .map(|(factor, name)| {
                let show = move |out: &mut String| out.push_str(&(notation.symbol)(name));
                (*factor, show)
            })
            .collect();
        write_sum(&mut inside, shows.iter().map(|(factor, show)| (*factor, show as &dyn Fn(&mut String))));
        let bare = matches!(self.argument.as_slice(), [(1, _)]);
        if bare {
            out.push(' ');
            out.push_str(&inside);
        } else {
            out.push_str(notation.open);
            out.push_str(&inside);
            out.push_str(notation.close);
        }
    }
}

impl Equation {
    fn render(&self, notation: &Notation) -> String {
        let mut out = String::new();
        let shows: Vec<_> = (self.terms.iter())
            .map(|term| {
                let show = move |out: &mut String| term.write(out, notation);
                (term.coefficient, show)
            })
            .collect();
        write_sum(&mut out, shows.iter().map(|(factor, show)| (*factor, show as &dyn Fn(&mut String))));
        if self.terms.is_empty() {
            out.push('0');
        }
        out.push_str(" = 0");
        out
    }

    /// Returns the equation in LaTeX (mathematics mode, without delimiters): `L_{2} \cos k - L_{3} \cos w - ... = 0`.
    #[must_use]
    pub fn latex(&self) -> String {
        self.render(&LATEX)
    }
}

impl fmt::Display for Equation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(&TEXT))
    }
}

/// Returns all equations as one LaTeX `align` environment, numbered by LaTeX.
#[must_use]
pub fn latex_align(equations: &[Equation]) -> String {
    let lines: Vec<String> =
        (equations.iter()).map(|equation| format!("  {}", equation.latex().replace(" = 0", " &= 0"))).collect();
    format!("\\begin{{align}}\n{}\n\\end{{align}}", lines.join(" \\\\\n"))
}

const GREEK: [&str; 24] = [
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu", "xi",
    "omicron", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega",
];

/// `L10` becomes `L_{10}`, `theta2` becomes `\theta_{2}`, `front` becomes `\mathrm{front}`.
fn latex_symbol(name: &str) -> String {
    if name.starts_with(|c: char| c.is_ascii_digit()) {
        return name.to_owned();
    }
    let split = name.find(|c: char| c == '_' || c.is_ascii_digit()).unwrap_or(name.len());
    let (stem, index) = name.split_at(split);
    let index = index.trim_start_matches('_').replace('_', r"\_");
    let stem = if GREEK.contains(&stem) {
        format!("\\{stem}")
    } else if stem.chars().count() > 1 {
        format!("\\mathrm{{{stem}}}")
    } else {
        stem.to_owned()
    };
    if index.is_empty() { stem } else { format!("{stem}_{{{index}}}") }
}

#[cfg(test)]
mod tests {
    use super::latex_symbol;

    /// Names come out as a mathematician would typeset them.
    #[test]
    fn names_become_latex() {
        for (name, latex) in [
            ("k", "k"),
            ("L10", "L_{10}"),
            ("theta2", r"\theta_{2}"),
            ("r_crank", "r_{crank}"),
            ("rod", r"\mathrm{rod}"),
            ("0.25", "0.25"),
        ] {
            assert_eq!(latex_symbol(name), latex);
        }
    }
}
