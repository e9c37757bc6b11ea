//! What was weighed and where it is to go, over the keyboard.

use std::borrow::Cow;

use erard::keyboard::KEYS;
use erard_figures::figure::{self, Dash, Figure, Layout, PALETTE, Panel, Scale, Trace, Window};
use erard_workshop::balance::BalancedKey;

use super::Work;

/// The figure.
pub fn figure_svg(work: &Work<'_>) -> String {
    let plan = work.plan;
    let weighed: Vec<f64> = plan.keys.iter().map(|key| key.measured.key as f64).collect();
    let all: Vec<f64> = (1..=KEYS).map(|key| key as f64).collect();
    let points = |label: &str, style: usize, of: &dyn Fn(&BalancedKey) -> Option<f64>| Trace {
        label: label.into(),
        x: &weighed,
        y: Cow::Owned(plan.keys.iter().map(|key| of(key).unwrap_or(f64::NAN)).collect()),
        colour: PALETTE[style],
        dash: Dash::Points,
    };
    let curve = |label: &str, style: usize, curve: &Option<[f64; KEYS]>| Trace {
        label: label.into(),
        x: &all,
        y: Cow::Owned(curve.map_or(vec![f64::NAN; KEYS], Vec::from)),
        colour: PALETTE[style],
        dash: Dash::Dashed,
    };
    let level = |label: &str, style: usize, value: Option<f64>| Trace {
        label: label.into(),
        x: &all,
        y: Cow::Owned(vec![value.unwrap_or(f64::NAN); KEYS]),
        colour: PALETTE[style],
        dash: Dash::Dashed,
    };
    let panel = |quantity: &str, unit, height_px, curves| Panel {
        quantity: quantity.into(),
        unit,
        height_px,
        layout: Layout::Together,
        y_range: None,
        curves,
    };
    let curves = &plan.curves;
    let mut inertia =
        vec![points("as weighed", 0, &|key| key.inertia_kg), points("after the leads", 1, &|key| key.after_inertia_kg)];
    if plan.target.inertia_kg.is_some() {
        inertia.push(level("aim", 6, plan.target.inertia_kg));
    }
    let panels = vec![
        panel(
            "strike weight",
            "g",
            130.0,
            vec![
                points("weighed", 0, &|key| key.measured.strike_weight_g),
                curve("aim", 6, &curves.target_strike_weight_g),
            ],
        ),
        panel(
            "front weight",
            "g",
            130.0,
            vec![
                points("weighed", 0, &|key| key.measured.front_weight_g),
                points("for the aim", 1, &|key| key.target_front_weight_g),
                curve("smooth aim", 6, &curves.target_front_weight_g),
            ],
        ),
        panel(
            "balance weight",
            "g",
            150.0,
            vec![
                points("weighed", 0, &|key| key.balance_weight_g),
                points("after the leads", 1, &|key| key.after_balance_weight_g),
                level("aim", 6, Some(plan.target_balance_weight_g)),
            ],
        ),
        panel("friction weight", "g", 110.0, vec![points("weighed", 3, &|key| key.friction_weight_g)]),
        panel("ratio", "", 110.0, vec![points("weighed", 2, &|key| key.ratio), curve("smooth", 6, &curves.ratio)]),
        panel("inertia", "kg", 110.0, inertia),
    ];
    figure::figure_svg(&Figure {
        title: format!("{}: weighed, and where it is to go", work.name),
        subtitle: format!("{}; points are keys, dashed lines are smooth curves and aims", work.file),
        width_px: 860.0,
        x_label: "number of the key, 1 = A0, 40 = C4, 88 = C8".into(),
        x_unit: 1.0,
        x_scale: Scale::Linear,
        windows: vec![Window { from: 0.0, to: 89.0, weight: 1.0, heading: String::new(), names_markers: false }],
        panels,
        markers: Vec::new(),
    })
}
