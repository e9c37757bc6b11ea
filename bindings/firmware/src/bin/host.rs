//! The note on this machine: the digests that a chip must find.

use erard_firmware::{Grand, STEP_S, play};
use moreau::Scalar;

fn digest<T: Scalar>(name: &str) {
    let mut grand = Grand::<T>::new(T::from_f64(STEP_S)).expect("it is sound");
    let note = play(&mut grand, &mut |step| {
        step();
    });
    println!("{name} {:016x} {:.3} rad/s", note.digest, note.fastest_rad_per_s);
}

fn main() {
    digest::<f32>("f32");
    digest::<f64>("f64");
}
