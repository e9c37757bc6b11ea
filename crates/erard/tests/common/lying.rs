//! The concert grand with its key lying on a punching of the balance rail.

use erard::Instrument;

/// The file's text, its key on a punching that is compressed as drawn by what lies on it, with dry friction along the
/// pin, N. The heel stays as stiff as where punching and heel are one felt.
pub fn lying_grand_text(friction_n: f64) -> String {
    let text = Instrument::builtin_text("concert-grand").unwrap();
    let zone = r#"[[zone]]
name = "balance_rail"
disc = { body = "key_back", center_mm = [0, 0] }
line = { body = "ground", point_mm = [0, 0.039], normal = [0, 1] }
felt = { stiffness_N_per_m_r = 1.33e9, exponent = 2, damping_N_s_per_m3 = 2.6e8, iwan_loss = 0.5, iwan_slip = 0.1 }
"#;
    let pin = format!("name = \"key_back\"\npin_friction_N = {friction_n}\n");
    format!("{text}\n{zone}").replacen("name = \"key_back\"\n", &pin, 1)
}

/// [`lying_grand_text`] with 0.3 N, read.
pub fn lying_grand() -> Instrument {
    Instrument::parse(&lying_grand_text(0.3), "lying.toml").unwrap()
}
