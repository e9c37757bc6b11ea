//! Two solvers of the one-step problem that share no code but the problem.

use moreau::{Settings, Solver};

use super::impact::{Play, tell};
use super::{Claim, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::stroke::{NUANCES, Touch};

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let mut plays: Vec<Play> =
        NUANCES.into_iter().flat_map(|n| [Play::Stroke(n, Touch::Pressed), Play::Stroke(n, Touch::Struck)]).collect();
    plays.extend([0.8, 2.0, 5.0, 8.0, 20.0, 35.0].map(Play::Force));
    let mut table = Table::new(
        "One second of each, 50 us, theta 1/2",
        &[
            "played",
            "speed, active set (m/s)",
            "speed, Gauss-Seidel (m/s)",
            "apart, relative",
            "active sets a step",
            "sweeps a step",
        ],
    );
    let settings = Settings::new(50e-6);
    let (mut worst, mut late, mut steps) = (0.0_f64, [0; 2], 0);
    for (i, play) in plays.iter().enumerate() {
        tell(progress, i as f64 / plays.len() as f64)?;
        let go = |solver| play.run(instrument, Settings { solver, ..settings }, 1.0, u64::MAX);
        let (a, b) = (go(Solver::ActiveSet)?, go(Solver::ProjectedGaussSeidel)?);
        let speeds = [&a, &b].map(|run| run.events.hammer_speed_m_per_s().unwrap_or(f64::NAN));
        let apart = (speeds[0] / speeds[1] - 1.0).abs();
        worst = if apart.is_nan() { f64::NAN } else { worst.max(apart) };
        late[0] += a.work.unconverged_steps;
        late[1] += b.work.unconverged_steps;
        steps += a.work.steps;
        let per_step = |run: &erard::run::Run| run.work.solver_iterations as f64 / run.work.steps as f64;
        table.row([
            play.label(),
            format!("{:.9}", speeds[0]),
            format!("{:.9}", speeds[1]),
            format!("{apart:.1e}"),
            format!("{:.2}", per_step(&a)),
            format!("{:.2}", per_step(&b)),
        ]);
    }
    Ok(Section {
        text: vec![
            "The papers solve the one-step problem by projected Gauss-Seidel on the augmented Lagrangian; it is kept as the reference. \
             The default guesses which laws stick and corrects the guess, and is exact."
                .into(),
        ],
        claims: vec![
            Claim::new(
                "[T12], [T13]",
                "the papers' solver and ours give the same motion, and ours leaves no step unconverged",
                format!("hammer speeds apart by at most {worst:.1e}; ours leaves {} of {steps} steps unconverged", late[0]),
                worst < 1e-6 && late[0] == 0,
            ),
            Claim::new(
                "this program",
                format!("the papers' solver too meets {:e} in every step within {} sweeps", settings.solver_tolerance, settings.solver_limit),
                format!("in all but {} of {steps} steps", late[1]),
                late[1] == 0,
            ),
        ],
        tables: vec![table],
        ..Section::default()
    })
}
