//! Time of a key press of the concert grand, engine only: one second of a played, held and released note (mf, 5 N) at 50 us,
//! 20 000 steps a sample. Real time is one second: the real-time factor is one second over the median.
//!
//! `cargo bench -p erard --bench press`

use divan::{Bencher, black_box};
use erard::{assembly, equilibrium, instrument::Instrument, mechanism::mechanism};
use moreau::{Input, Model, Outcome, Scratch, Settings, Solver, State, step};

fn main() {
    divan::main();
}

const STEP_S: f64 = 50e-6;
const STEPS: u64 = 20_000;

type Grand = (Model<f64, 6, 14>, State<f64, 6, 14>);

fn grand() -> Grand {
    let instrument = Instrument::builtin("concert-grand").expect("built in");
    let mut rest = mechanism(&instrument, Settings::new(STEP_S)).expect("assembles");
    equilibrium::settle(rest.as_mut(), &Input::Free).expect("settles");
    let angles = core::array::from_fn(|i| rest.angles()[i]);
    (assembly::assemble(&instrument).expect("fits"), State::at_rest(angles))
}

fn press((model, state): &Grand, settings: &Settings<f64>) -> State<f64, 6, 14> {
    let (mut state, mut scratch) = (state.clone(), Scratch::<f64, 6, 14, 10>::new());
    for n in 0..STEPS {
        let input = if n < STEPS / 2 { Input::Force(5.0) } else { Input::Force(0.0) };
        let report = step(model, settings, &input, &mut state, &mut scratch);
        assert_ne!(report.outcome, Outcome::NonFinite);
    }
    state
}

#[divan::bench(sample_count = 50)]
fn active_set(bencher: Bencher) {
    let (grand, settings) = (grand(), Settings::new(STEP_S));
    bencher.bench_local(|| press(black_box(&grand), &settings));
}

#[divan::bench(sample_count = 50)]
fn projected_gauss_seidel(bencher: Bencher) {
    let grand = grand();
    let settings = Settings { solver: Solver::ProjectedGaussSeidel, ..Settings::new(STEP_S) };
    bencher.bench_local(|| press(black_box(&grand), &settings));
}
