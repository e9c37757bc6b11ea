//! Plan of the work, key by key: weights, quantities derived from them, and work that reaches the target.

use erard::keyboard::{KEYS, note_name};

use super::equation::{Balance, Parts};
use super::leads::{LeadChoice, LeadWork, lead_choice};
use super::measured::MeasuredKey;
use super::model::KeyModel;
use super::neighbours::{Apart, Weighed, apart};
use super::smooth::smooth;
use crate::measure::norms::lines;
use crate::measure::usual::usual;

/// A balance weight nearer to its target stays, g: D and U are weighed in steps of 2 g.
pub const LEAST_BALANCE_G: f64 = 2.0;
/// Step of a hammer's weight, g: the resolution of a scale.
const HAMMER_STEP_G: f64 = 0.1;
/// Largest move of a capstan, mm: technicians stop at 4.5 to 8 mm, for the heel ends and the aftertouch is used up.
pub const MOST_CAPSTAN_MM: f64 = 8.0;
/// Aftertouch that a move of 1 mm toward the player costs, mm: 3 to 6.5 mm on five drawn grands (effects.csv).
pub const AFTERTOUCH_PER_CAPSTAN: f64 = 0.18;
/// Most that springs or magnets take off, g: above 10 to 15 g technicians do not like the touch (Love, Pianotech list,
/// June 2003).
const MOST_ASSIST_G: f64 = 15.0;
/// Share by which a strike weight after the work may be out of its usual range: beyond, the shank would be bare.
const STRIKE_ROOM: f64 = 0.1;
/// Step of front weight where no leads are named, g.
const FRONT_STEP_G: f64 = 0.5;

/// Goal of the work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Balance weight of every key, g.
    pub balance_weight_g: f64,
    /// Effective inertia of every key at its front, kg; if given, the hammers follow it and not the smooth curve.
    pub inertia_kg: Option<f64>,
    /// Whether all hammers are first brought to their target strike weights, before the leads; otherwise only those
    /// that differ from their neighbours.
    pub hammers: bool,
}

/// Curves over the keyboard, the first key at index 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Strike weights, smoothed, g; `None` if too few were weighed.
    pub strike_weight_g: Option<[f64; KEYS]>,
    /// Ratios, smoothed.
    pub ratio: Option<[f64; KEYS]>,
    /// Target strike weights: the smooth ones, or those for the target inertia, g.
    pub target_strike_weight_g: Option<[f64; KEYS]>,
    /// Front weights with which keys of the smooth ratio and the target strike weights have the target balance weight,
    /// g.
    pub target_front_weight_g: Option<[f64; KEYS]>,
}

/// Single change that brings a key to the target balance weight.
#[derive(Debug, Clone, PartialEq)]
pub enum Remedy {
    /// Leads.
    Leads(LeadWork),
    /// Change of strike weight, g.
    Strike(f64),
    /// Move of the capstan toward the player, mm.
    Capstan(f64),
    /// More of what springs or magnets take off, g.
    Assist(f64),
}

/// Reason why a remedy is withheld.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// The capstan would leave the heel.
    Heel,
    /// The aftertouch would be this, mm, and no dip in its range makes up for it.
    Aftertouch(f64),
    /// Springs or magnets would take this off, g.
    Assist(f64),
    /// The strike weight would be this, g, far out of its usual range.
    StrikeWeight(f64),
    /// The model does not do what the equation says, g; `None` if no weight moves the key.
    Model(Option<f64>),
    /// At a checked key the model does not do what the equation says of a move that is no larger.
    AsChecked,
}

/// A remedy that is not given.
#[derive(Debug, Clone, PartialEq)]
pub struct Withheld {
    /// The remedy as the equation has it.
    pub remedy: Remedy,
    /// Reason.
    pub bound: Bound,
}

/// A key with its measured and derived quantities.
#[derive(Debug, Clone, PartialEq)]
pub struct BalancedKey {
    /// Measured weights.
    pub measured: MeasuredKey,
    /// Note of the key.
    pub note: String,
    /// Model of the key.
    pub model: KeyModel,
    /// KR used: weighed, or the model's.
    pub key_ratio: f64,
    /// WW used: weighed, or the model's, g.
    pub whippen_weight_g: f64,
    /// SW used: weighed, or from the smooth curve, g.
    pub strike_weight_g: Option<f64>,
    /// BW: weighed, or by the equation with the smooth ratio, g.
    pub balance_weight_g: Option<f64>,
    /// F, g; `None` unless both D and U were measured.
    pub friction_weight_g: Option<f64>,
    /// R: by the equation from this key's own weights, or from the smooth curve.
    pub ratio: Option<f64>,
    /// Effective inertia at the front, kg.
    pub inertia_kg: Option<f64>,
    /// Whether any of these come from a curve and not from this key.
    pub from_curves: bool,
    /// Target strike weight of the key, g.
    pub target_strike_weight_g: Option<f64>,
    /// Front weight for the target balance weight, with the hammer as it is or changed first, g.
    pub target_front_weight_g: Option<f64>,
    /// Quantities that differ from the neighbours by more than the error of readings and the scatter of the other keys.
    pub apart: Vec<Apart>,
    /// Change of strike weight before the leads, g, positive for a heavier hammer; 0 if the hammer stays.
    pub hammer_change_g: f64,
    /// Front weight to add by leads, g: 0 if they stay, `None` if too little is known.
    pub front_change_g: Option<f64>,
    /// Whether the ceiling of the front weight keeps the leads from adding more.
    pub is_at_ceiling: bool,
    /// Leads that reach the target. `None` if leads must go but are unknown, or if no leads reach it.
    pub leads: Option<LeadChoice>,
    /// Change of strike weight that would suffice alone, g; `None` also if it is withheld.
    pub strike_change_g: Option<f64>,
    /// Move of the capstan toward the player that would suffice alone, mm; `None` also if it is withheld.
    pub capstan_move_mm: Option<f64>,
    /// More of what springs or magnets take off that would suffice alone, g; `None` for a key without them, and if it
    /// is withheld.
    pub assist_change_g: Option<f64>,
    /// Remedies out of bounds, or refuted by the model.
    pub withheld: Vec<Withheld>,
    /// Balance weight after the leads (and the hammer, if it is changed first), g.
    pub after_balance_weight_g: Option<f64>,
    /// Inertia after the leads (and the hammer, if it is changed first), kg.
    pub after_inertia_kg: Option<f64>,
}

/// Plan for a keyboard: keys, curves, and target balance weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The weighed keys, ascending.
    pub keys: Vec<BalancedKey>,
    /// The curves.
    pub curves: Curves,
    /// Goal of the work.
    pub target: Target,
}

/// Plans the work. `models` has every key's model, the first key at index 0; `leads_g` are the masses of available
/// leads.
#[must_use]
pub fn plan(measured: &[MeasuredKey], models: &[KeyModel; KEYS], target: Target, leads_g: &[f64]) -> Plan {
    let target_balance_weight_g = target.balance_weight_g;
    let mut strike_weights = [None; KEYS];
    let mut ratios = [None; KEYS];
    for key in measured {
        let model = &models[key.key - 1];
        strike_weights[key.key - 1] = key.strike_weight_g;
        let parts = key.front_weight_g.zip(key.strike_weight_g).map(|(front_weight_g, strike_weight_g)| Parts {
            front_weight_g,
            strike_weight_g,
            whippen_weight_g: key.whippen_weight_g.unwrap_or(model.whippen_weight_g),
            key_ratio: key.key_ratio.unwrap_or(model.key_ratio),
            assist_g: key.assist_g.unwrap_or(0.0),
        });
        ratios[key.key - 1] = parts.zip(key.balance()).map(|(parts, own)| parts.ratio(own.balance_weight_g()));
    }
    let strike_weight_g = smooth(&strike_weights);
    let ratio = smooth(&ratios);
    let target_strike_weight_g = match (target.inertia_kg, ratio) {
        (None, _) => strike_weight_g,
        (Some(inertia_kg), Some(ratio)) => Some(std::array::from_fn(|i| {
            let model = &models[i];
            let whippen_g = model.key_ratio * model.whippen_weight_g;
            model.strike_weight_for_inertia(inertia_kg, ratio[i], whippen_g, target_balance_weight_g)
        })),
        (Some(_), None) => None,
    };
    let target_front_weight_g = target_strike_weight_g.zip(ratio).map(|(strike, ratio)| {
        std::array::from_fn(|i| {
            let model = &models[i];
            model.key_ratio * model.whippen_weight_g + ratio[i] * strike[i] - target_balance_weight_g
        })
    });
    let curves = Curves { strike_weight_g, ratio, target_strike_weight_g, target_front_weight_g };
    let weighed: Vec<Weighed> = measured.iter().map(|key| Weighed::of(key, ratios[key.key - 1])).collect();
    let apart = apart(&weighed);
    let keys = measured
        .iter()
        .zip(apart)
        .map(|(key, apart)| {
            let at = key.key - 1;
            let known = Known { balance: key.balance(), ratio: ratios[at], apart };
            balanced(key, &models[at], known, &curves, target, leads_g)
        })
        .collect();
    Plan { keys, curves, target }
}

/// Quantities derived from a key's own weights.
struct Known {
    balance: Option<Balance>,
    ratio: Option<f64>,
    apart: Vec<Apart>,
}

/// Change of strike weight before the leads, g: to the target for all hammers, or to its neighbours for one that
/// differs.
fn hammer_change_g(strike_g: Option<f64>, aim_g: Option<f64>, apart: &[Apart], all: bool) -> f64 {
    let alone = apart.iter().find(|apart| apart.quantity == "strike_weight_g").map(|apart| apart.neighbours);
    let aim_g = if all { aim_g } else { alone };
    let by_g = strike_g.zip(aim_g).map_or(0.0, |(now, aim)| aim - now);
    (by_g / HAMMER_STEP_G).round() * HAMMER_STEP_G
}

/// Upper end of the usual front weight of a key, g.
fn ceiling_g(key: usize) -> f64 {
    let line = lines().find(|line| line.key == "front_weight_g");
    line.and_then(|line| line.range(key)[1]).unwrap_or(f64::INFINITY)
}

/// Usual strike weights of a key, g.
fn strike_range_g(key: usize) -> [f64; 2] {
    let line = lines().find(|line| line.key == "strike_weight_g");
    let [low, high] = line.map_or([None; 2], |line| line.range(key));
    [low.unwrap_or(0.0), high.unwrap_or(f64::INFINITY)]
}

/// Bound of a capstan's move by the aftertouch of a key, where that was read: a move to the player takes aftertouch,
/// and a deeper dip gives it back, as far as dips are usual.
fn aftertouch_bound(key: &MeasuredKey, by_mm: f64) -> Option<Bound> {
    let range = |line: &str| usual(line).map_or([None; 2], |range| range.faults(key.key));
    let then_mm = key.aftertouch_mm? - AFTERTOUCH_PER_CAPSTAN * by_mm;
    let ([low, high], [shallow, deep]) = (range("aftertouch_mm"), range("dip_mm"));
    let room =
        |end: Option<f64>, sign: f64| key.dip_mm.zip(end).map_or(0.0, |(now, end)| (sign * (end - now)).max(0.0));
    let is_short = low.is_some_and(|low| then_mm + room(deep, 1.0) < low);
    let is_long = high.is_some_and(|high| then_mm - room(shallow, -1.0) > high);
    // What is out already and comes nearer is no reason against it.
    ((is_short && by_mm > 0.0) || (is_long && by_mm < 0.0)).then_some(Bound::Aftertouch(then_mm))
}

fn balanced(
    key: &MeasuredKey,
    model: &KeyModel,
    known: Known,
    curves: &Curves,
    target: Target,
    leads_g: &[f64],
) -> BalancedKey {
    let at = key.key - 1;
    let of = |curve: &Option<[f64; KEYS]>| curve.map(|curve| curve[at]);
    let key_ratio = key.key_ratio.unwrap_or(model.key_ratio);
    let whippen_weight_g = key.whippen_weight_g.unwrap_or(model.whippen_weight_g);
    let strike_weight_g = key.strike_weight_g.or(of(&curves.strike_weight_g));
    let ratio = known.ratio.or(of(&curves.ratio));
    let parts = key.front_weight_g.zip(strike_weight_g).map(|(front_weight_g, strike_weight_g)| Parts {
        front_weight_g,
        strike_weight_g,
        whippen_weight_g,
        key_ratio,
        assist_g: key.assist_g.unwrap_or(0.0),
    });
    let weighed = known.balance.map(|balance| balance.balance_weight_g());
    let balance_weight_g = weighed.or_else(|| Some(parts?.balance_weight_g(ratio?)));
    let target_strike_weight_g = of(&curves.target_strike_weight_g);
    let inertia = |strike_g: Option<f64>, front_g: Option<f64>| Some(model.inertia_kg(strike_g?, front_g?, ratio?));

    // The hammer first, if it is brought to its target; then the leads for the rest.
    let target_g = target.balance_weight_g;
    let own_strike_g = if target.hammers { strike_weight_g } else { key.strike_weight_g };
    let hammer_change_g = hammer_change_g(own_strike_g, target_strike_weight_g, &known.apart, target.hammers);
    let balance_then_g = match hammer_change_g {
        0.0 => balance_weight_g,
        by_g => balance_weight_g.zip(ratio).map(|(balance_g, ratio)| balance_g + ratio * by_g),
    };
    // A gram more front weight is a gram less balance weight.
    let wanted_g = balance_then_g.map(|balance_g| balance_g - target_g);
    let room_g = key.front_weight_g.map_or(f64::INFINITY, |front_g| (ceiling_g(key.key) - front_g).max(0.0));
    let front_change_g =
        wanted_g.map(|by_g| by_g.min(room_g)).map(|by_g| if by_g.abs() < LEAST_BALANCE_G { 0.0 } else { by_g });
    let is_at_ceiling = wanted_g.is_some_and(|by_g| by_g >= LEAST_BALANCE_G && by_g > room_g);
    // If the leads are unknown, the technician must see which can go.
    let for_the_eye =
        |by_g: f64| by_g < 0.0 && key.leads.is_empty() && key.front_weight_g.is_none_or(|front_g| front_g + by_g > 0.0);
    let leads = front_change_g
        .filter(|by_g| !for_the_eye(*by_g))
        .and_then(|by_g| lead_choice(by_g, model.key_front_mm, leads_g, &key.leads));
    let front_change_g = front_change_g.map(|by_g| match &leads {
        Some(leads) => leads.work.front_weight_g,
        None => (by_g / FRONT_STEP_G).round() * FRONT_STEP_G,
    });
    let strike_change_g = balance_weight_g.zip(ratio).map(|(balance_g, ratio)| (target_g - balance_g) / ratio);
    // The capstan changes the weight of everything above it by one factor.
    let capstan_move_mm = balance_weight_g.zip(key.front_weight_g).and_then(|(balance_g, front_g)| {
        let factor = (target_g + front_g) / (balance_g + front_g);
        (factor.is_finite() && factor > 0.0).then(|| model.capstan_move_mm(factor))
    });
    let mut withheld = Vec::new();
    let strike_change_g = strike_change_g.filter(|by_g| {
        let then_g = strike_weight_g.map(|now| now + by_g);
        let is_out = then_g.is_some_and(|then_g| {
            let [low, high] = strike_range_g(key.key);
            !((1.0 - STRIKE_ROOM) * low..=(1.0 + STRIKE_ROOM) * high).contains(&then_g)
        });
        let bound = then_g.filter(|_| is_out).map(Bound::StrikeWeight);
        withheld.extend(bound.map(|bound| Withheld { remedy: Remedy::Strike(*by_g), bound }));
        !is_out
    });
    let capstan_move_mm = capstan_move_mm.filter(|by_mm| {
        let too_far = (by_mm.abs() > MOST_CAPSTAN_MM).then_some(Bound::Heel);
        let bound = too_far.or_else(|| aftertouch_bound(key, *by_mm));
        withheld.extend(bound.map(|bound| Withheld { remedy: Remedy::Capstan(*by_mm), bound }));
        bound.is_none()
    });
    let assist_change_g = balance_weight_g.zip(key.assist_g).map(|(balance_g, _)| balance_g - target_g);
    let assist_change_g = assist_change_g.filter(|by_g| {
        let then_g = key.assist_g.unwrap_or(0.0) + by_g;
        let bound = (!(0.0..=MOST_ASSIST_G).contains(&then_g)).then_some(Bound::Assist(then_g));
        withheld.extend(bound.map(|bound| Withheld { remedy: Remedy::Assist(*by_g), bound }));
        bound.is_none()
    });
    let after_balance_weight_g = balance_then_g.zip(front_change_g).map(|(g, by_g)| g - by_g);
    let after_strike_g = strike_weight_g.map(|now| now + hammer_change_g);
    let after_inertia_kg = match &leads {
        Some(leads) => inertia(after_strike_g, key.front_weight_g).map(|kg| kg + 1e-3 * leads.work.inertia_g),
        None => inertia(after_strike_g, key.front_weight_g.zip(front_change_g).map(|(now, by)| now + by)),
    };
    BalancedKey {
        note: note_name(key.key),
        model: *model,
        key_ratio,
        whippen_weight_g,
        strike_weight_g,
        balance_weight_g,
        friction_weight_g: known.balance.map(|balance| balance.friction_weight_g()),
        ratio,
        inertia_kg: inertia(strike_weight_g, key.front_weight_g),
        from_curves: key.strike_weight_g.is_none() || known.ratio.is_none() || weighed.is_none(),
        target_strike_weight_g,
        target_front_weight_g: key.front_weight_g.zip(wanted_g).map(|(now, by)| now + by),
        apart: known.apart,
        hammer_change_g,
        front_change_g,
        is_at_ceiling,
        leads,
        strike_change_g,
        capstan_move_mm,
        assist_change_g,
        withheld,
        after_balance_weight_g,
        after_inertia_kg,
        measured: key.clone(),
    }
}
