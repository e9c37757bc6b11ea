//! What was weighed and where it is to go, over the keyboard.

use erard::keyboard::KEYS;
use erard_figures::Picture;
use erard_figures::figure::{Dash, Figure, Panel, Trace, figure_picture};
use erard_workshop::balance::BalancedKey;
use erard_workshop::worklist::KeyboardList;

use super::Work;
use crate::keyboard::KEY_NUMBERS;

/// The figure.
pub(crate) fn weighed_picture(work: &Work<'_>) -> Picture {
    let plan = &work.list.plan;
    let weighed: Vec<f64> = plan.keys.iter().map(|key| key.measured.key as f64).collect();
    let all: Vec<f64> = (1..=KEYS).map(|key| key as f64).collect();
    let points = |label: &str, style: usize, of: &dyn Fn(&BalancedKey) -> Option<f64>| {
        let y: Vec<f64> = plan.keys.iter().map(|key| of(key).unwrap_or(f64::NAN)).collect();
        Trace::new(label, &weighed, y, style, Dash::Alone)
    };
    let curve = |label: &str, style: usize, curve: &Option<[f64; KEYS]>| {
        Trace::new(label, &all, curve.map_or(vec![f64::NAN; KEYS], Vec::from), style, Dash::Dashed)
    };
    let level = |label: &str, style: usize, value: Option<f64>| {
        Trace::new(label, &all, vec![value.unwrap_or(f64::NAN); KEYS], style, Dash::Dashed)
    };
    let usual = |label: &str, end: usize| {
        let of = |key: usize| KeyboardList::usual_friction_g(key)[end];
        Trace::new(label, &all, (1..=KEYS).map(of).collect::<Vec<f64>>(), 6, Dash::Dashed)
    };
    // What is to be weighed again first has no weights to come.
    let waits = |key: &BalancedKey| work.list.waits(key);
    let curves = &plan.curves;
    let mut inertia = vec![
        points("as weighed", 0, &|key| key.inertia_kg),
        points("after the list", 1, &|key| if waits(key) { None } else { key.after_inertia_kg }),
    ];
    if plan.target.inertia_kg.is_some() {
        inertia.push(level("aim", 6, plan.target.inertia_kg));
    }
    let panels = vec![
        Panel::new(
            "strike weight",
            "g",
            130.0,
            vec![
                points("weighed", 0, &|key| key.measured.strike_weight_g),
                curve("aim", 6, &curves.target_strike_weight_g),
            ],
        ),
        Panel::new(
            "front weight",
            "g",
            130.0,
            vec![
                points("weighed", 0, &|key| key.measured.front_weight_g),
                points("for the aim", 1, &|key| key.target_front_weight_g),
                curve("smooth aim", 6, &curves.target_front_weight_g),
            ],
        ),
        Panel::new(
            "balance weight",
            "g",
            150.0,
            vec![
                points("weighed", 0, &|key| key.balance_weight_g),
                points("after the list", 1, &|key| if waits(key) { None } else { key.after_balance_weight_g }),
                level("aim", 6, Some(plan.target.balance_weight_g)),
            ],
        ),
        Panel::new(
            "friction weight",
            "g",
            130.0,
            vec![points("weighed", 3, &|key| key.friction_weight_g), usual("usual, to", 1)],
        ),
        Panel::new("ratio", "", 110.0, vec![points("weighed", 2, &|key| key.ratio), curve("smooth", 6, &curves.ratio)]),
        Panel::new("inertia", "kg", 110.0, inertia),
    ];
    let title = format!("{}: weighed, and where it is to go", work.file);
    let subtitle =
        format!("points are keys, dashed lines smooth curves, aims and usual ranges; not weighed: {}", work.name);
    figure_picture(&Figure::over(KEY_NUMBERS, (0.0, 89.0), title, subtitle, panels))
}
