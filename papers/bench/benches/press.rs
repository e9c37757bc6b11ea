//! Time of a key press of the concert grand: one second of a played, held and released note (mf, 5 N) at 50 us, 20 000
//! steps a sample. Real time is one second: the real-time factor is one second over the median.
//!
//! `active_set` and `projected_gauss_seidel` are the engine alone. `action` steps the player from outside and reads
//! everything after every step. `recorded` and `recorded_with_ledger` are whole runs, from the search for the rest on,
//! all columns of every step kept in memory.
//!
//! `cargo bench -p erard-bench --bench press`

use divan::{Bencher, black_box};
use erard::{Action, Drive, Input, Setup};
use erard_bench::{MF_N, STEP_S, STEPS, grand, instrument, press};
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

#[divan::bench(sample_count = 50)]
fn action(bencher: Bencher) {
    let grand = Action::new(&instrument()).expect("it comes to rest");
    let rest = grand.save();
    let mut grand = grand;
    grand.set_sleep(false);
    bencher.bench_local(|| {
        grand.restore(&rest).expect("its own");
        for n in 0..STEPS {
            black_box(grand.step(Input::Force(if n < STEPS / 2 { MF_N } else { 0.0 })));
            black_box(grand.impact());
        }
    });
}

#[divan::bench(sample_count = 50)]
fn recorded(bencher: Bencher) {
    run(bencher, false);
}

#[divan::bench(sample_count = 50)]
fn recorded_with_ledger(bencher: Bencher) {
    run(bencher, true);
}

fn run(bencher: Bencher, ledger: bool) {
    let grand = instrument();
    let drive: &Drive = &|t| Input::Force(if t < 0.5 { MF_N } else { 0.0 });
    let setup = Setup { ledger, ..Setup::new(STEPS as f64 * STEP_S) };
    bencher.bench_local(|| erard::press(black_box(&grand), drive, &setup).expect("it runs"));
}
