//! Deviations that depend only on a sample's number and a name: a new number in a file does not change the others.

use erard::saved::{FNV1A, fnv1a};

/// Distance from 2 that contains nine tenths of all sums of four uniform numbers: 2 less the root of d^4 - 4 (d - 1)^4
/// = 1.2.
const NINE_TENTHS: f64 = 0.9534;

/// Returns a bell-shaped deviation, nine tenths of the time within -1 and 1, never beyond 2.1. Uses integers, sums and
/// one division: the same bits everywhere.
pub(super) fn deviation(sample: u32, attempt: u32, name: &str, component: usize) -> f64 {
    let mut state =
        mixed(fnv1a(FNV1A, name.bytes()) ^ mixed(u64::from(sample) << 32 | u64::from(attempt)) ^ component as u64);
    let sum: f64 = (0..4).map(|_| uniform(&mut state)).sum();
    (sum - 2.0) / NINE_TENTHS
}

/// Returns a number from 0 to 1, all equally likely, that does not depend on the attempt.
pub(super) fn share(sample: u32, name: &str) -> f64 {
    uniform(&mut mixed(fnv1a(FNV1A, name.bytes()) ^ mixed(u64::from(sample) << 32)))
}

fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(GOLDEN_GAMMA);
    (mixed(*state) >> 11) as f64 * (0.5_f64).powi(53)
}

/// SplitMix64 (Steele, Lea and Flood 2014).
const GOLDEN_GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean 0, nine tenths within 1, variance of four uniform numbers; other names, samples, attempts and components
    /// are independent.
    #[test]
    fn deviations_are_distributed_as_said() {
        const N: u32 = 20_000;
        let all: Vec<f64> = (1..=N).map(|sample| deviation(sample, 0, "felt", 0)).collect();
        let n = f64::from(N);
        let mean = all.iter().sum::<f64>() / n;
        let variance = all.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / n;
        let within = all.iter().filter(|u| u.abs() <= 1.0).count() as f64 / n;
        // Four standard errors.
        let expected = 4.0 / 12.0 / (NINE_TENTHS * NINE_TENTHS);
        assert!(mean.abs() < 4.0 * (expected / n).sqrt(), "{mean}");
        assert!((variance / expected - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{variance} {expected}");
        assert!((within - 0.9).abs() < 4.0 * (0.09 / n).sqrt(), "{within}");
        for (name, attempt, component) in [("wood", 0, 0), ("felt", 1, 0), ("felt", 0, 1)] {
            let other = (1..=N).map(|sample| deviation(sample, attempt, name, component));
            let product = all.iter().zip(other).map(|(a, b)| a * b).sum::<f64>() / n;
            assert!(product.abs() < 4.0 * expected / n.sqrt(), "{name} {attempt} {component}: {product}");
        }
    }

    /// All shares are equally likely: mean a half, variance a twelfth, as many below a quarter as above three.
    #[test]
    fn shares_are_even() {
        const N: u32 = 20_000;
        let all: Vec<f64> = (1..=N).map(|sample| share(sample, "balance weight")).collect();
        let n = f64::from(N);
        let mean = all.iter().sum::<f64>() / n;
        let variance = all.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / n;
        assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12.0 / n).sqrt(), "{mean}");
        assert!((12.0 * variance - 1.0).abs() < 4.0 * (0.8 / n).sqrt(), "{variance}");
        for quarter in [0.0, 0.75] {
            let within = all.iter().filter(|u| (quarter..quarter + 0.25).contains(*u)).count() as f64 / n;
            assert!((within - 0.25).abs() < 4.0 * (0.1875 / n).sqrt(), "{quarter}: {within}");
        }
    }

    /// Expected bits, computed by another program.
    #[test]
    fn deviations_have_their_bits() {
        let found = [deviation(17, 0, "cloth: stiffness", 0), deviation(200, 3, "body.hammer.mass_g", 1)];
        assert_eq!(found.map(f64::to_bits), BITS, "{:#x?}", found.map(f64::to_bits));
    }

    const BITS: [u64; 2] = [0xbfe5_ef97_7cd0_425f, 0xbf9c_aec6_8d82_4cdf];
}
