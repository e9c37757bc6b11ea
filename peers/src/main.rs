//! The same action by a stiff solver.
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let m = mechanism::read(&path).unwrap();
    use run::*;
    for method in [Method::Bdf, Method::Esdirk34, Method::TrBdf2] {
        for w in [0.3,0.01,1e-3, 1e-4,1e-5] {
            for tol in [1e-2,1e-3,1e-4,1e-5, 1e-8] {
                let s = Setup{method, tolerance: tol, widths: equations::Widths{pivot:w, sliding:0.1*w}};
                let r = run::run(&m, &s, &|t| m.blow.force(t), &[m.blow.until_s]);
                match r {
                    Ok(r) => println!("{} w {w:.0e} tol {tol:.0e}: {:?} err {:.2e} {:.3} ms {} steps {:.2} us/step", method.name(), r.strike, r.strike.map_or(f64::NAN, |s| s[0]/2.3108045-1.0), r.seconds*1e3, r.steps, r.seconds*1e6/r.steps as f64),
                    Err(e) => println!("{} w {w} tol {tol}: {e}", method.name()),
                }
            }
        }
    }
}
mod equations;
mod mechanism;
mod number;
mod run;
