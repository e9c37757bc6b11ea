//! Simulated values by the names in the table's rows. Each name ends with its unit.

use super::grands::{self, BesideGrands};
use super::presses::{Loudness, SimulatedPress};
use super::release::{Hump, Releases};
use super::repeats::Repeats;
use super::touches::Touches;
use crate::diagnose::Bench;
use crate::measure::flex::POUND_N;
use crate::measure::{LoopNumbers, Sheet};

const MS_PER_S: f64 = 1e3;
const MM_PER_M: f64 = 1e3;
/// The weight of a kilogram, N.
const KG_N: f64 = 9.81;

/// Iterates over all names for rows.
pub fn names() -> impl Iterator<Item = &'static str> {
    let grands = super::grands::NAMES.iter().map(String::as_str);
    NAMES.into_iter().chain(super::strings::NAMES).chain(super::keys::NAMES).chain(grands)
}

/// Names of values without strings.
const NAMES: [&str; 69] = [
    "down_weight_g",
    "up_weight_g",
    "balance_weight_g",
    "friction_weight_g",
    "strike_weight_ratio_weights",
    "whippen_weight_g",
    "dip_mm",
    "blow_mm",
    "let_off_mm",
    "drop_mm",
    "aftertouch_mm",
    "check_mm",
    "effective_inertia_kg",
    "repetition_rate_hz",
    "repetition_rate_half_hz",
    "starting_force_N",
    "force_of_a_20_ms_stroke_N",
    "hammer_speed_at_0_8_N_m_per_s",
    "force_for_4_5_m_s_N",
    "key_stroke_at_0_8_N_ms",
    "key_stroke_at_15_N_ms",
    "key_stroke_f_ms",
    "longest_key_stroke_ms",
    "key_velocity_softest_m_per_s",
    "key_velocity_at_15_N_m_per_s",
    "key_velocity_ramped_15_N_m_per_s",
    "key_velocity_mf_m_per_s",
    "key_velocity_f_m_per_s",
    "hammer_ahead_at_0_8_N_ms",
    "hammer_ahead_f_ms",
    "hammer_ahead_softest_ms",
    "hammer_ahead_at_35_N_ms",
    "crossover_m_per_s",
    "string_contact_mf_ms",
    "struck_sooner_ms",
    "struck_plateau_share",
    "release_to_damper_ms",
    "hammer_ahead_pressed_f_ms",
    "hammer_ahead_pressed_ff_ms",
    "hammer_ahead_pressed_loudest_ms",
    "crossover_pressed_m_per_s",
    "key_stroke_pressed_ff_ms",
    "hammer_ahead_led_pp_ms",
    "hammer_ahead_led_softest_ms",
    "key_stroke_led_pp_ms",
    "key_flex_mm_per_kg",
    "shank_flex_mm_per_lb",
    "let_off_resistance_N",
    "damper_resistance_N",
    "damper_start_mm",
    "struck_force_pp_N",
    "struck_force_p_N",
    "struck_force_mf_N",
    "struck_force_ff_N",
    "let_go_home_ms",
    "let_go_speed_m_per_s",
    "let_go_humps",
    "let_go_first_ms",
    "let_go_first_mm",
    "let_go_second_ms",
    "let_go_second_mm",
    "led_up_home_ms",
    "led_up_rebound_mm",
    "hammer_sinks_ms",
    "hammer_bounces_ms",
    "hammer_bounces_again_ms",
    "least_lift_share",
    "least_lift_without_lever_share",
    "key_friction_weight_g",
];

/// Compliance of parts on the bench, m/N; `None` without the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Flex {
    /// Of the key at its playing end.
    pub key_m_per_n: Option<f64>,
    /// Of the shank at the pound.
    pub shank_m_per_n: Option<f64>,
}

/// Simulated results of an instrument.
#[derive(Debug)]
pub(super) struct Simulated {
    pub sheet: Sheet,
    pub loudness: Loudness,
    pub touches: Touches,
    pub releases: Releases,
    pub grands: Vec<BesideGrands>,
    pub repeats: Repeats,
    pub flex: Flex,
    pub bench: Bench,
}

/// Distance from the damper's start, and from the bottom, within which the damper's share does not count, mm: let-off
/// between them is in both loops.
const AWAY_MM: f64 = 1.0;

/// Contribution of the damper to the force of a slow press, N.
fn damper_resistance(sheet: &Sheet) -> Option<f64> {
    let with = sheet.hysteresis_dampers_down.as_ref()?;
    let from = sheet.damper_start_share? * sheet.dip_mm? + AWAY_MM;
    let to = sheet.dip_mm? - AWAY_MM;
    let mean = |way: &LoopNumbers| {
        let rows = way.down_key_mm.iter().zip(&way.down_force_N).filter(|(key, _)| (from..to).contains(*key));
        let (sum, count) = rows.fold((0.0, 0_u32), |(sum, count), (_, force)| (sum + force, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    };
    Some(mean(with)? - mean(&sheet.hysteresis)?)
}

/// Value of a name, in the unit that ends it; `None` if the event did not happen or the name is unknown.
pub(super) fn value(name: &str, found: &Simulated) -> Option<f64> {
    let Simulated { sheet, loudness, touches, releases, grands, repeats, flex, bench } = found;
    let ms = |seconds: Option<f64>| seconds.map(|s| s * MS_PER_S);
    let of = |press: &Option<SimulatedPress>, get: fn(&SimulatedPress) -> Option<f64>| press.as_ref().and_then(get);
    let mm = |metres: Option<f64>| metres.map(|m| m * MM_PER_M);
    let Releases { let_go, led_up } = releases;
    let hump = |which: usize, get: fn(&Hump) -> f64| let_go.humps.as_ref()?.get(which).map(get);
    let l = loudness;
    let hand = &l.by_hand;
    match name {
        "down_weight_g" => sheet.down_weight_g,
        "up_weight_g" => sheet.up_weight_g,
        "balance_weight_g" => sheet.balance_weight_g,
        "friction_weight_g" => sheet.friction_weight_g,
        "strike_weight_ratio_weights" => sheet.strike_weight_ratio_weights,
        "whippen_weight_g" => Some(sheet.whippen_weight_g),
        "dip_mm" => sheet.dip_mm,
        "blow_mm" => sheet.blow_mm,
        "let_off_mm" => sheet.let_off_mm,
        "drop_mm" => sheet.drop_mm,
        "aftertouch_mm" => sheet.aftertouch_mm,
        "check_mm" => sheet.check_mm,
        "effective_inertia_kg" => Some(sheet.effective_inertia_kg),
        "repetition_rate_hz" => sheet.repetition_rate_hz,
        "repetition_rate_half_hz" => sheet.repetition_rate_half_hz,
        "starting_force_N" => l.starting_force_n,
        "force_of_a_20_ms_stroke_N" => l.force_of_a_20_ms_stroke_n,
        "hammer_speed_at_0_8_N_m_per_s" => l.at_0_8_n.hammer_speed_m_per_s,
        "force_for_4_5_m_s_N" => l.force_for_ff_n,
        "key_stroke_at_0_8_N_ms" => ms(l.at_0_8_n.key_stroke_s),
        "key_stroke_at_15_N_ms" => ms(l.at_15_n.key_stroke_s),
        "key_stroke_f_ms" => ms(of(&l.f, |b| b.key_stroke_s)),
        "longest_key_stroke_ms" => ms(of(&l.softest, |b| b.key_stroke_s)),
        "key_velocity_softest_m_per_s" => of(&l.softest, |b| Some(b.key_speed_m_per_s)),
        "key_velocity_at_15_N_m_per_s" => Some(l.at_15_n.key_speed_m_per_s),
        "key_velocity_ramped_15_N_m_per_s" => Some(l.ramped_15_n.key_speed_m_per_s),
        "key_velocity_mf_m_per_s" => of(&l.mf, |b| Some(b.key_speed_m_per_s)),
        "key_velocity_f_m_per_s" => of(&l.f, |b| Some(b.key_speed_m_per_s)),
        "hammer_ahead_at_0_8_N_ms" => ms(l.at_0_8_n.hammer_ahead_s),
        "hammer_ahead_f_ms" => ms(of(&l.f_by_stroke, |b| b.hammer_ahead_s)),
        "hammer_ahead_softest_ms" => ms(of(&l.softest, |b| b.hammer_ahead_s)),
        "hammer_ahead_at_35_N_ms" => ms(l.at_35_n.hammer_ahead_s),
        "crossover_m_per_s" => l.crossover_m_per_s,
        "string_contact_mf_ms" => ms(of(&l.mf, |b| b.contact_s)),
        "struck_sooner_ms" => ms(touches.struck_sooner_s),
        "struck_plateau_share" => Some(touches.plateau_m? * MM_PER_M / sheet.dip_mm?),
        "release_to_damper_ms" => ms(touches.release_to_damper_s),
        "hammer_ahead_pressed_f_ms" => ms(of(&hand.f_by_stroke, |b| b.hammer_ahead_s)),
        "hammer_ahead_pressed_ff_ms" => ms(of(&hand.ff, |b| b.hammer_ahead_s)),
        "hammer_ahead_pressed_loudest_ms" => ms(hand.loudest.hammer_ahead_s),
        "crossover_pressed_m_per_s" => hand.crossover_m_per_s,
        "key_stroke_pressed_ff_ms" => ms(of(&hand.ff, |b| b.key_stroke_s)),
        "hammer_ahead_led_pp_ms" => ms(of(&hand.pp, |b| b.hammer_ahead_s)),
        "hammer_ahead_led_softest_ms" => ms(of(&hand.softest, |b| b.hammer_ahead_s)),
        "key_stroke_led_pp_ms" => ms(of(&hand.pp, |b| b.key_stroke_s)),
        "let_off_resistance_N" => sheet.let_off_resistance_N,
        "damper_resistance_N" => damper_resistance(sheet),
        "damper_start_mm" => Some(sheet.damper_start_share? * sheet.dip_mm?),
        "struck_force_pp_N" => of(&hand.struck[0], |b| Some(b.peak_n)),
        "struck_force_p_N" => of(&hand.struck[1], |b| Some(b.peak_n)),
        "struck_force_mf_N" => of(&hand.struck[2], |b| Some(b.peak_n)),
        "struck_force_ff_N" => of(&hand.struck[3], |b| Some(b.peak_n)),
        "let_go_home_ms" => ms(let_go.home_s),
        "let_go_speed_m_per_s" => let_go.speed_m_per_s,
        "let_go_humps" => let_go.humps.as_ref().map(|humps| humps.len() as f64),
        "let_go_first_ms" => ms(hump(0, |hump| hump.top_s)),
        "let_go_first_mm" => mm(hump(0, |hump| hump.height_m)),
        "let_go_second_ms" => ms(hump(1, |hump| hump.top_s)),
        "let_go_second_mm" => mm(hump(1, |hump| hump.height_m)),
        "led_up_home_ms" => ms(led_up.home_s),
        "led_up_rebound_mm" => mm(led_up.rebound_m),
        "hammer_sinks_ms" => ms(led_up.hammer_s[0]),
        "hammer_bounces_ms" => ms(led_up.hammer_s[1]),
        "hammer_bounces_again_ms" => ms(led_up.hammer_s[3]),
        "key_flex_mm_per_kg" => Some(flex.key_m_per_n? * KG_N * MM_PER_M),
        "shank_flex_mm_per_lb" => Some(flex.shank_m_per_n? * POUND_N * MM_PER_M),
        "least_lift_share" => repeats.with_lever,
        "least_lift_without_lever_share" => repeats.without_lever,
        "key_friction_weight_g" => Some(bench.key_alone_g),
        other => grands::value(other, grands).flatten(),
    }
}
