//! The poses as a table.

use std::io::Write;

use super::Shown;
use crate::table::write_rows;

/// The columns. Angles are the equations' own `k`, `w`, `h`, absolute; `s1_mm` and `s2_mm` are `S1` and `S2` (for discs: at
/// rest, and from there by what the surfaces slide); the slidings are their change since rest; `leverage` is the head's
/// speed upward over the speed of the key's front.
pub(crate) const COLUMNS: [&str; 11] = [
    "case",
    "key_mm",
    "key_rad",
    "whippen_rad",
    "hammer_rad",
    "s1_mm",
    "s2_mm",
    "capstan_sliding_mm",
    "knuckle_sliding_mm",
    "hammer_mm",
    "leverage",
];

/// Writes all cases, one below the other.
///
/// # Errors
/// Of the writer.
pub(crate) fn write_csv(cases: &[Shown], writer: &mut dyn Write) -> std::io::Result<()> {
    let poses = cases.iter().flat_map(|shown| shown.stroke.poses.iter().map(move |pose| (shown, pose)));
    let rows = poses.map(|(shown, pose)| {
        // Adding zero turns -0 into 0.
        let mm = |metres: f64| metres * 1e3 + 0.0;
        let numbers = [
            mm(pose.key),
            pose.k,
            pose.w,
            pose.h,
            mm(shown.s1(pose)),
            mm(shown.s2(pose)),
            mm(pose.capstan_sliding),
            mm(pose.knuckle_sliding),
            mm(pose.head_rise),
            pose.leverage,
        ];
        ([&shown.name], numbers.map(Some))
    });
    write_rows(&COLUMNS, rows, writer)
}
