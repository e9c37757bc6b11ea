//! The poses as a table.

use std::io::Write;

use super::Shown;
use crate::table::shortest;

/// The columns. Angles are the equations' own `k`, `w`, `h`, absolute; `s1_mm` and `s2_mm` are `S1` and `S2` (for discs: at
/// rest, and from there by what the surfaces slide); the slidings are their change since rest; `leverage` is the head's
/// speed upward over the speed of the key's front.
pub const COLUMNS: [&str; 11] = [
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
pub fn write_csv(cases: &[Shown], writer: &mut dyn Write) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    csv.write_record(COLUMNS)?;
    let mut text = String::new();
    for shown in cases {
        for pose in &shown.stroke.poses {
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
            csv.write_field(&shown.name)?;
            for number in numbers {
                text.clear();
                shortest(number, &mut text);
                csv.write_field(&text)?;
            }
            csv.write_record(None::<&[u8]>)?;
        }
    }
    csv.flush()
}
