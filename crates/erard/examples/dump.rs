//! scratch
use erard::{instrument::Instrument, simulation::*};
use moreau::Settings;
fn main() {
    let g = Instrument::builtin("concert-grand").unwrap();
    let a: Vec<f64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    let force = |t: f64| if t < a[1] { a[0] } else { 0.0 };
    let setup = Setup { settings: Settings::new(50e-6), duration_s: a[2], record_every: Some(4) };
    let r = simulate(&g, &Drive::Force(&force), &setup, &mut |_| true).unwrap();
    print!("t,F,key,head");
    for b in &r.bodies {
        print!(",{}", b.name);
    }
    for z in &r.zones {
        print!(",{}", z.name);
    }
    println!();
    for i in 0..r.time_s.len() {
        print!("{},{},{},{}", r.time_s[i], r.force_n[i], r.key_m[i] * 1e3, r.hammer_head_m[i] * 1e3);
        for b in &r.bodies {
            print!(",{}", b.angle_rad[i]);
        }
        for z in &r.zones {
            print!(",{}", z.normal_n[i]);
        }
        println!();
    }
}
