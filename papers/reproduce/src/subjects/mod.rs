//! The papers' figures and claims, recomputed: numbers and verdicts, no pictures.
//!
//! \[T12\] Thorin, Boutillon, Lozada, Merlhiot, *Simulation of a non-smooth dynamical model of the piano key*; \[T13\]
//! Thorin, Boutillon, Merlhiot, Lozada, *A non-smooth simulation of the dynamics of the grand piano action*, Waves
//! 2013; \[H\] Hirschkorn, Birkett, McPhee, *Kinematic model of a piano action mechanism*.
//!
//! [`subjects`] lists them; each is computed independently and gives a [`Section`]. All numbers are reproducible except
//! clock times, which are in marked tables and in no figure.

mod bushings;
mod conformance_rows;
mod contact;
mod control;
mod convergence;
mod dampers;
mod drives;
mod dynamics;
mod energy;
mod events;
mod felt_losses;
mod friction;
mod gives;
mod humps;
mod impact;
mod landing;
mod levers;
mod lying;
mod order;
mod outlook;
mod release;
mod solvers;
mod strings;
mod struck;
mod touch;
mod train;
mod train_loss;
mod transfer;
mod weight;

use thiserror::Error;

pub(crate) use erard_figures::figure::{Chart, ChartCurve, ChartPanel, Dash};

use erard::instrument::Instrument;
use erard::one_dof::OneDofError;
use erard::run::SimulationError;
use erard_kinematics::DeriveError;
use erard_workshop::compare::CompareError;

/// A subject to reproduce.
#[derive(Clone, Copy)]
pub struct Subject {
    /// Name on the command line, e.g. `paper2-convergence`.
    pub name: &'static str,
    /// Headline.
    pub title: &'static str,
    /// Share of the whole work, for progress.
    pub weight: f64,
    /// Computes the section.
    pub run: fn(&Instrument, &mut Progress) -> Result<Section, ReproduceError>,
}

pub use erard::Progress;

/// Section of the report on a subject.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Method, in paragraphs.
    pub text: Vec<String>,
    /// Claims, each with its verdict.
    pub claims: Vec<Claim>,
    /// Figures.
    pub charts: Vec<Chart>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Equations as the program generates them, with a caption.
    pub listings: Vec<(String, String)>,
}

/// A claim of a paper (or of this program about itself), with the measured value.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// Source, e.g. `[T12] fig. 3`.
    pub source: &'static str,
    /// The claim.
    pub says: String,
    /// Value measured here.
    pub measured: String,
    /// Whether it holds.
    pub holds: bool,
}

impl Claim {
    fn new(source: &'static str, says: impl Into<String>, measured: impl Into<String>, holds: bool) -> Self {
        Claim { source, says: says.into(), measured: measured.into(), holds }
    }
}

/// A table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Caption.
    pub caption: String,
    /// Column names.
    pub header: Vec<String>,
    /// Cells.
    pub rows: Vec<Vec<String>>,
    /// Whether it holds clock times, which differ from run to run.
    pub clock: bool,
}

impl Table {
    fn new(caption: impl Into<String>, header: &[&str]) -> Self {
        let header = header.iter().map(|h| (*h).to_owned()).collect();
        Table { caption: caption.into(), header, rows: Vec::new(), clock: false }
    }

    fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }
}

/// Reason why a subject cannot be computed.
#[derive(Debug, Error)]
pub enum ReproduceError {
    /// A run failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A comparison failed.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// The one-degree-of-freedom model failed.
    #[error(transparent)]
    OneDof(#[from] OneDofError),
    /// The levers failed.
    #[error(transparent)]
    Levers(#[from] DeriveError),
    /// A change of the instrument is not possible.
    #[error(transparent)]
    Invalid(#[from] erard::instrument::InvalidInstrument),
    /// A change of the instrument names a part that it does not have.
    #[error(transparent)]
    Index(#[from] erard::IndexError),
    /// The instrument does not show the subject's behaviour.
    #[error("{0}")]
    Instrument(String),
}

/// All subjects, in the order of the report.
#[must_use]
pub fn subjects() -> Vec<Subject> {
    let subject = |name, title, weight, run| Subject { name, title, weight, run };
    vec![
        subject("paper1-drives", "Force-driven and motion-driven, six bodies and one", 3.0, drives::section),
        subject("paper1-transfer", "From force to displacement and back", 1.0, transfer::section),
        subject(
            "paper1-fine-structure",
            "The fine structure of the force, and whether it is felt",
            1.0,
            touch::fine_structure,
        ),
        subject("touch-scatter", "How much of a touch's scatter reaches the impact", 6.0, touch::scatter),
        subject("paper2-felt", "The felt law", 1.0, friction::felt),
        subject("paper2-rest", "Rest under dry and under regularised friction", 14.0, friction::rest),
        subject("paper2-convergence", "Convergence and cost, set-valued and regularised", 18.0, convergence::section),
        subject("paper2-finger", "The finger's softness", 2.0, friction::finger),
        subject("paper2-run-time", "Run time against real time", 2.0, friction::run_time),
        subject("paper3-levers", "Kinematics of the three levers", 0.5, levers::section),
        subject("scheme-order", "Order of the scheme", 6.0, order::section),
        subject("scheme-control", "Fixed and adaptive steps", 14.0, control::section),
        subject("scheme-energy", "Energy balance", 1.5, energy::section),
        subject("scheme-solvers", "Agreement of the solvers", 1.5, solvers::section),
        subject("felt-losses", "Which loss the felts should have", 4.0, felt_losses::section),
        subject("bushings", "Pivots on compliant bushings", 1.0, bushings::section),
        subject("conformance", "Textbook problems with known answers", 40.0, conformance_rows::section),
        subject("what-gives", "What yields in a loud note, and what it does to timing", 8.0, gives::section),
        subject("train-felts", "Stiffness and loss of heel and knuckle", 16.0, train::section),
        subject("train-loss", "What heel and knuckles give back of a blow", 0.5, train_loss::section),
        subject("dynamics", "From gentle to loud: touches, hands, travel times", 3.0, dynamics::section),
        subject("struck-hand", "What the struck hand does", 6.0, struck::section),
        subject("lying-key", "The key that lies on its balance rail", 2.0, lying::section),
        subject("released-key", "The key that is let go, and why it rebounds", 1.0, release::section),
        subject("events", "How events converge, and which of them are chance", 6.0, events::section),
        subject("laid-weight", "A weight laid on the key", 1.0, weight::section),
        subject("strings", "Modal strings and their bridge", 6.0, strings::section),
        subject(
            "strings-energy",
            "The energy balance of a note with strings over the step",
            2.0,
            strings::residual::section,
        ),
        subject("strings-aftersound", "What makes a note fall in two stages", 60.0, strings::aftersound::section),
        subject("dampers", "Dampers over the compass, and half-pedalling", 8.0, dampers::section),
        subject("contact", "How long the hammer touches, and what decides it", 1.0, contact::section),
        subject("outlook", "What the papers leave for later", 0.1, outlook::section),
    ]
}

fn builtin(name: &str) -> Result<Instrument, ReproduceError> {
    Instrument::builtin(name).map_err(|e| ReproduceError::Instrument(e.to_string()))
}

/// The requested instrument, or the concert grand if that has no bends.
fn bending(asked: &Instrument) -> Result<Instrument, ReproduceError> {
    if asked.has_bends() { Ok(asked.clone()) } else { builtin("concert-grand") }
}

/// Formats two digits, and a plain zero.
fn small(x: f64) -> String {
    if x == 0.0 { "0".into() } else { format!("{x:.1e}") }
}
