//! Every row of every problem holds, and the references are the textbooks' numbers.

use std::collections::BTreeMap;
use std::sync::{LazyLock, OnceLock};

use moreau_conformance::{Expected, Problem, ProblemRow, problems};

/// A problem, and its rows once a test has asked for them.
type Solved = (Problem, OnceLock<Vec<ProblemRow>>);

/// Every problem by its number.
static SOLVED: LazyLock<BTreeMap<u32, Solved>> =
    LazyLock::new(|| problems().into_iter().map(|problem| (problem.number, (problem, OnceLock::new()))).collect());

fn solved(number: u32) -> (&'static Problem, &'static [ProblemRow]) {
    let (problem, rows) = SOLVED.get(&number).expect("a problem of this number");
    (problem, rows.get_or_init(problem.rows))
}

fn holds(number: u32) {
    let (problem, rows) = solved(number);
    assert!(!rows.is_empty());
    for row in rows {
        assert!(
            row.holds(),
            "{}: {} is {} and should be {:?}: {}",
            problem.name,
            row.quantity,
            row.ours,
            row.expected,
            row.because
        );
    }
}

macro_rules! problems_hold {
    ($($name:ident $number:literal)*) => {
        $(#[test] fn $name() { holds($number); })*
    };
}

problems_hold! {
    pivot_that_sticks 1
    oscillator_with_dry_friction 2
    pendulum_with_a_dry_pivot 3
    double_pendulum 4
    elastic_felt 5
    damped_felt 6
    relay_problems 7
    oscillator_on_a_belt 9
    block_on_an_incline 10
    disc_from_sliding_to_rolling 11
    bouncing_ball 12
    painleves_rod 13
    steps_with_controlled_error 15
    stack_of_tilted_blocks 16
    rocking_block 17
    kanes_paradox 18
    surfaces_that_end 19
    scotch_yoke 20
    torsion_springs_and_stiff_springs 21
    hunt_and_crossleys_felt 22
    felt_with_a_dry_loss 23
    felt_with_a_dry_loss_that_slips 24
    stulovs_hereditary_felt 25
    friction_that_grows_at_rest 26
    felt_with_sliders_in_parallel 27
    difference_quotients_through_an_impact 28
}

#[test]
#[ignore = "ci: two loops turn for a hundred seconds"]
fn closed_loops() {
    holds(14);
}

/// The references that the rows compute are these numbers, which were evaluated elsewhere to ten digits.
#[test]
fn the_references_are_the_published_numbers() {
    for (number, quantity, value) in [
        (2, "turning point 1, h = 1e-3", 13.317_821_063),
        (2, "turning point 2, h = 1e-3", -11.317_821_063),
        (2, "rests at, h = 1e-3", 0.682_178_936_724),
        (2, "from, h = 1e-3", 22.423_556_350_699),
        (3, "turning point 1, h = 1e-5", 0.349_759_265),
        (3, "turning point 2, h = 1e-5", 0.202_136_563),
        (3, "turning point 3, h = 1e-5", 0.055_977_470),
        (5, "r = 2: largest compression", 6.694_329_500_8e-4),
        (5, "r = 2: contact time", 1.877_333_806_6e-3),
        (5, "r = 2.5: largest compression", 6.169_670_082_2e-4),
        (5, "r = 2.5: contact time", 1.666_704_945_2e-3),
        (5, "r = 3: largest compression", 6.687_403_049_8e-4),
        (5, "r = 3: contact time", 1.753_475_568_5e-3),
        (9, "static limit 1.5: slips for, h = 1e-2", 3.902_605_407_8),
        (9, "static limit 1.5: period, h = 1e-2", 8.902_605_407_8),
        (10, "mu 0.3, from rest: acceleration downhill", 0.589_702_223_1),
        (10, "mu 0.5, uphill at 1 m/s: stops at, h = 1e-2", 0.125_558_580_1),
        (10, "mu 0.5, uphill at 1 m/s: way after 2 s, h = 1e-2", 0.062_779_290_1),
        (11, "rolls from, h = 1e-2", 0.169_894_665_3),
        (12, "first impact, h = 1e-3", 0.428_352_936_9),
        (12, "comes to rest, h = 1e-3", 8.138_705_800_7),
        (13, "mu 0.5: normal force over mass, h = 1e-6", 5.605_714_285_7),
        // By a Runge-Kutta method of order 4 at steps of 20 ns, in another language.
        (22, "r = 2, a = 0.6: speed of rebound", 0.711_950_179_6),
        (22, "r = 2.5, a = 0.6: largest compression", 5.621_843_078_4e-4),
        (22, "r = 3, a = 0.3: speed of rebound", 0.832_869_792_3),
        (22, "r = 3, a = 2: speed of rebound", 0.410_719_686_1),
        (22, "r = 3, a = 2: largest compression", 5.479_335_690_9e-4),
        // Closed forms; by Runge and Kutta's method at steps of 0.2 us, in another language, the same to eight digits.
        (23, "r = 2, eta = 0.3, 1 m/s: rebound over arrival", 0.733_799_385_7),
        (24, "r = 2, eta = 0.3, 1 m/s: rebound over arrival", 0.832_050_294_3),
        (25, "r = 1, sinusoidal, 20 ms: area of the loop", 1.509_563_694e-3),
        (26, "pivot: rest after which 1.2 of the kinetic friction is held", 0.102_165_124_8),
    ] {
        let (_, rows) = solved(number);
        let row = rows.iter().find(|r| r.quantity == quantity).unwrap_or_else(|| panic!("no row {quantity}"));
        // The last digit that is given, rounded.
        let digits = if number == 3 { 6e-10 } else { 6e-11 };
        let Expected::Near { value: reference, .. } = row.expected else { panic!("{quantity}: no value") };
        assert!((reference - value).abs() <= digits * value.abs().max(1.0), "{quantity}: {reference}");
    }
}
