//! Time of a key press of the concert grand, engine only: one second of a played, held and released note (mf, 5 N) at 50 us,
//! 20 000 steps a sample. Real time is one second: the real-time factor is one second over the median.
//!
//! `cargo bench -p erard --bench press`

use divan::{Bencher, black_box};
use erard_lab::benchmarks::{STEP_S, STEPS, grand, press};
use moreau::{Settings, Solver};

fn main() {
    divan::main();
}

#[divan::bench(sample_count = 50)]
fn active_set(bencher: Bencher) {
    let (grand, settings) = (grand(), Settings::new(STEP_S));
    bencher.bench_local(|| press(black_box(&grand), &settings, STEPS));
}

#[divan::bench(sample_count = 50)]
fn projected_gauss_seidel(bencher: Bencher) {
    let grand = grand();
    let settings = Settings { solver: Solver::ProjectedGaussSeidel, ..Settings::new(STEP_S) };
    bencher.bench_local(|| press(black_box(&grand), &settings, STEPS));
}
