//! Table of the poses.

use erard_kinematics::three_lever::StrokePose;

use super::shown::Shown;
use crate::table::Table;

/// Makes a table of all cases, one below the other. Angles are the equations' own `k`, `w`, `h`, absolute; `s1_mm` and
/// `s2_mm` are `S1` and `S2` (for discs: at rest, plus the sliding of the surfaces); the slidings are their change
/// since rest; `leverage` is the head's upward speed over the speed of the key's front.
pub(crate) fn table(cases: &[Shown]) -> Table<'static> {
    type Number = (&'static str, fn(&Shown, &StrokePose) -> f64);
    const NUMBERS: [Number; 10] = [
        ("key_mm", |_, pose| mm(pose.key)),
        ("key_rad", |_, pose| pose.k),
        ("whippen_rad", |_, pose| pose.w),
        ("hammer_rad", |_, pose| pose.h),
        ("s1_mm", |shown, pose| mm(shown.s1(pose))),
        ("s2_mm", |shown, pose| mm(shown.s2(pose))),
        ("capstan_sliding_mm", |_, pose| mm(pose.capstan_sliding)),
        ("knuckle_sliding_mm", |_, pose| mm(pose.knuckle_sliding)),
        ("hammer_mm", |_, pose| mm(pose.head_rise)),
        ("leverage", |_, pose| pose.leverage),
    ];
    let poses = || cases.iter().flat_map(|shown| shown.stroke.poses.iter().map(move |pose| (shown, pose)));
    let table = Table::default().words("case", poses().map(|(shown, _)| shown.name.clone()));
    NUMBERS.into_iter().fold(table, |table, (name, number)| {
        table.optional(name, poses().map(|(shown, pose)| Some(number(shown, pose))))
    })
}

/// Adding zero turns -0 into 0.
fn mm(metres: f64) -> f64 {
    metres * 1e3 + 0.0
}
