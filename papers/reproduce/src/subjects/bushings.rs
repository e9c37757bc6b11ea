//! Compliant bushings of pivots, and their effect on the order of events.

use moreau::Settings;

use super::impact::{Play, tell};
use super::{Claim, Progress, ReproduceError, Section, Table};
use erard::instrument::{Bushing, Instrument};

/// Stiffnesses, N/m. Wool cloth of 0.6 mm under interference, 2 to 10 MPa on 1.3 x 6.4 mm: 0.5e5 to 3e5 N/m, both sides
/// together. An estimate; none is published.
const STIFFNESSES: [f64; 4] = [1e6, 3e5, 1e5, 3e4];
/// Damping ratio of 10 g on the bushing.
const RATIO: f64 = 0.1;
/// Constant force of a forte, N.
const FORTE_N: f64 = 9.0;

/// Key bottom minus hammer contact, ms, and the hammer's speed, m/s.
fn forte(instrument: &Instrument) -> Result<Option<[f64; 2]>, ReproduceError> {
    let run = Play::Force(FORTE_N).run(instrument, Settings::new(25e-6), 0.12, u64::MAX)?;
    let events = &run.events;
    Ok(events
        .key_bottom_s
        .zip(events.hammer_contact_s())
        .zip(events.hammer_speed_m_per_s())
        .map(|((bottom, contact), speed)| [1e3 * (bottom - contact), speed]))
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let missing = || ReproduceError::Instrument("9 N strike no string or leave the key above its bottom".into());
    let mut table = Table::new(
        format!(
            "{FORTE_N} N held, 25 us: hammer and whippen on bushings that give up and down; nothing is regulated again"
        ),
        &["stiffness of each (N/m)", "key bottom minus hammer contact (ms)", "change (ms)", "hammer (m/s)"],
    );
    let rigid = forte(instrument)?.ok_or_else(missing)?;
    table.row(["rigid".into(), format!("{:.3}", rigid[0]), "0".into(), format!("{:.3}", rigid[1])]);
    // The hammer's own pivot: for a flexible shank, the first piece's.
    let hammer = instrument.roles.hammer.and_then(|hammer| instrument.first_piece(hammer).ok()).ok_or_else(missing)?;
    let whippen = instrument
        .bodies
        .iter()
        .position(|body| body.name == "whippen")
        .ok_or_else(|| ReproduceError::Instrument("the instrument has no body `whippen`".into()))?;
    // The later one first, so that the other keeps its index.
    let (first, second) = (whippen.max(hammer), whippen.min(hammer));
    let mut most = 0.0_f64;
    for (i, n_per_m) in STIFFNESSES.into_iter().enumerate() {
        tell(progress, (i + 1) as f64 / (STIFFNESSES.len() + 1) as f64)?;
        let cloth = Bushing::Cloth { n_per_m, n_s_per_m: 2.0 * RATIO * (n_per_m * 0.010_f64).sqrt() };
        let soft = instrument.with_bushing(first, cloth)?.with_bushing(second, cloth)?;
        let [ahead, speed] = forte(&soft)?.ok_or_else(missing)?;
        if n_per_m >= 1e5 {
            most = most.max((ahead - rigid[0]).abs());
        }
        table.row([
            format!("{n_per_m:.0e}"),
            format!("{ahead:.3}"),
            format!("{:+.3}", ahead - rigid[0]),
            format!("{speed:.3}"),
        ]);
    }
    Ok(Section {
        text: vec![
            "Centre pins turn in cloth, which gives under load. An instrument file can say so of any pivot (`bushing_N_per_m`); the built-in ones do not, \
             because it changes next to nothing."
                .into(),
        ],
        claims: vec![Claim::new(
            "this program",
            "bushings of 1e5 N/m and stiffer move the order of events at forte by at most 0.1 ms",
            format!("by {most:.3} ms"),
            most <= 0.1,
        )],
        tables: vec![table],
        ..Section::default()
    })
}
