use erard::{instrument::Instrument, one_dof, simulation::*};
use moreau::Settings;
fn main() {
    let g = Instrument::builtin("concert-grand").unwrap();
    let a: Vec<f64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    let dt = a.first().copied().unwrap_or(50e-6);
    for f in [0.8, 2.0, 5.0, 8.0, 20.0, 35.0] {
        let force = |_t: f64| f;
        let setup = Setup { settings: Settings::new(dt), start_s: 0.0, duration_s: 0.5, record_every: None };
        let r = simulate(&g, &Drive::Force(&force), &setup, &mut |_| true).unwrap();
        let e = &r.events;
        let ms = |x: Option<f64>| x.map_or(f64::NAN, |x| x * 1e3);
        println!(
            "{f:5} N: start {:.2} toe {:.2} letoff {:.2} string {:.3} bottom {:.3} check {:.2} speed {:.5} | kb-ks {:.1} lead {:.2} | res {:.2e} small {:.1e} | newton {:.2} solver {:.2} unconv {} rtf {:.0} strikes {:?}",
            ms(e.key_start_s),
            ms(e.toe_contact_s),
            ms(e.let_off_s),
            ms(e.hammer_contact_s),
            ms(e.key_bottom_s),
            ms(e.check_s),
            e.hammer_speed_m_s.unwrap_or(f64::NAN),
            ms(e.key_bottom_s) - ms(e.key_start_s),
            ms(e.key_bottom_s) - ms(e.hammer_contact_s),
            r.ledger.residual_relative(),
            r.ledger.smallest_term,
            r.work.newton_iterations as f64 / r.work.steps as f64,
            r.work.solver_iterations as f64 / r.work.newton_iterations as f64,
            r.work.unconverged_steps,
            r.work.real_time_factor,
            e.strikes.len()
        );
        println!(
            "   end hammer head {:.3} mm, v {:?}",
            r.hammer_head_m.last().unwrap() * 1e3,
            r.bodies.iter().map(|b| b.rate_rad_per_s.last().unwrap()).collect::<Vec<_>>()
        );
    }
    let o = one_dof::reduce(&g).unwrap();
    println!(
        "J {} alpha {} ratios {:?} dry {} visc {}",
        o.inertia_kg_m2,
        o.moment_n_m,
        o.ratios,
        o.instrument.bodies[0].friction_torque_n_m,
        o.instrument.bodies[0].viscous_n_m_s
    );
    println!("J at front {:.3} kg, down {:.3} N", o.inertia_kg_m2 / 0.265 / 0.265, o.moment_n_m / 0.265);
}
