//! Derivatives of a press against differences, against each other, and what has none.

use erard::gradient::{Direction, GradientError, follow};
use erard::instrument::Dwell;
use erard::{Input, Instrument, Settings, Setup};
use erard_workshop::sensitivities::{Mark, Sensitivities, Sensitivity, Variable, quantities, sensitivities};

fn found(name: &str, by: &[&str], of: &[&str], force_n: f64) -> Sensitivities {
    let (instrument, text) = (Instrument::builtin(name).unwrap(), Instrument::builtin_text(name).unwrap());
    let by = by.iter().map(|name| Variable::named(&instrument, text, name).unwrap()).collect();
    let of = quantities().into_iter().filter(|q| of.contains(&q.key)).collect();
    let setup = Setup { settings: Settings::new(25e-6), ledger: false, ..Setup::new(0.2) };
    let stroke = || -> erard_workshop::study::Stroke<'static> { Box::new(move |_| Input::Force(force_n)) };
    sensitivities(&instrument, by, of, &stroke, &setup, 2, &mut |_| true).unwrap()
}

fn by<'a>(all: &'a Sensitivities, name: &str, of: &str) -> &'a Sensitivity {
    all.rows.iter().find(|row| all.by[row.by].name == name && all.of[row.of].key == of).unwrap()
}

/// What matters most for a blow has the slope that differences over a window see, which is thousands of times wider than what one step resolves.
#[test]
fn derivatives_are_what_wide_differences_see() {
    let names = ["let_off", "capstan_height", "zone.jack_knuckle.friction", "spring.repetition.torque", "force"];
    for instrument in ["concert-grand-rigid", "concert-grand"] {
        let of = ["hammer_speed_m_per_s", "hammer_contact_s"];
        let all = found(instrument, &names, &of, 5.0);
        assert!(all.switches[0] > 5, "{:?}", all.switches);
        for row in &all.rows {
            let ([slope, error], name) = (row.differences.unwrap(), &all.by[row.by].name);
            let apart = (slope - row.derivative).abs();
            assert!(
                apart < 0.03 * slope.abs() + error + row.error,
                "{instrument} {name} {}: {row:?}",
                all.of[row.of].key
            );
            assert_eq!(row.mark, Mark::None, "{instrument} {name} {row:?}");
        }
        // A stronger finger is faster, and earlier.
        assert!(by(&all, "force", of[0]).derivative > 0.0 && by(&all, "force", of[1]).derivative < 0.0);
    }
}

/// A parameter by its name and the same number by its path in the file have one derivative; what a blow is over before has none.
#[test]
fn a_number_has_one_derivative_whatever_it_is_called() {
    let (name, path) = ("zone.jack_knuckle.friction", "zone.jack_knuckle.friction_coefficient");
    let of = "hammer_speed_m_per_s";
    let all = found("concert-grand-rigid", &[name, path, "back_check", "zone.check.stiffness"], &[of], 5.0);
    let (percent, unit) = (by(&all, name, of), by(&all, path, of));
    let value = all.by[unit.by].value.unwrap();
    assert!((unit.derivative * value / 100.0 / percent.derivative - 1.0).abs() < 1e-6, "{percent:?} {unit:?}");
    let elasticity = percent.elasticity(&all).unwrap();
    assert!((elasticity / unit.elasticity(&all).unwrap() - 1.0).abs() < 1e-6 && (-0.2..-0.01).contains(&elasticity));
    for nothing in ["back_check", "zone.check.stiffness"] {
        assert_eq!(by(&all, nothing, of).derivative, 0.0, "{nothing}");
    }
}

/// Touch weights: a percent more hammer weighs what the ratio of the parts says, about; what is lead in the key helps.
#[test]
fn touch_weights_have_differences() {
    let all = found("concert-grand-rigid", &["body.hammer.mass"], &["down_weight_g", "balance_weight_g"], 5.0);
    for row in &all.rows {
        assert!((0.1..2.0).contains(&row.derivative) && row.error < 0.1 * row.derivative, "{row:?}");
    }
    assert_eq!(all.rows.len(), 2);
}

/// Static friction is not derived, and says so.
#[test]
fn what_is_not_derived_is_refused() {
    let deep = std::thread::Builder::new().stack_size(erard::gradient::STACK_BYTES);
    deep.spawn(refusals).unwrap().join().unwrap();
}

fn refusals() {
    let mut grand = Instrument::builtin("concert-grand-rigid").unwrap();
    grand.bodies[0].dwell = Some(Dwell { ratio: 1.5, time_s: 0.1 });
    let setup = Setup { ledger: false, ..Setup::new(0.1) };
    let refused = follow(&grand, &[Direction::force()], &|_| Input::Force(5.0), &setup, 50e-6, None, &|| true);
    assert!(matches!(refused, Err(GradientError::Dwell)), "{refused:?}");
    let mut grand = Instrument::builtin("concert-grand-rigid").unwrap();
    grand.zones[0].felt.dry_loss = 0.2;
    let refused = follow(&grand, &[Direction::force()], &|_| Input::Force(5.0), &setup, 50e-6, None, &|| true);
    assert!(matches!(refused, Err(GradientError::SetValuedFelt)), "{refused:?}");
    let plain = Instrument::builtin("concert-grand-rigid").unwrap();
    let stopped = follow(&plain, &[], &|_| Input::Force(5.0), &setup, 50e-6, None, &|| false);
    assert!(stopped.is_err_and(|error| error.is_interruption()));
}
