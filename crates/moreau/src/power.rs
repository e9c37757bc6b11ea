//! A power of a positive number, for felts whose exponent is none of the usual ones: x^y = 2^(y log2 x).
//!
//! With x = 2^e m, 1/sqrt(2) <= m < sqrt(2), log2 m = 2/ln 2 artanh(s), s = (m - 1)/(m + 1), by its series. y e is
//! exact in two parts, so that the logarithm's whole part costs no digits. Products and sums only, none fused, and no
//! table: the same bits on every machine. A felt asks for two powers in every pass of every step; `libm::pow`, which
//! rounds correctly nearly always, took half of the time of drawing a sample.

/// 1.5 * 2^52: a sum with it holds the nearest whole number in its last bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// The bits of 1/sqrt(2), rounded up.
const HALF_ROOT: u64 = 0x3FE6_A09E_667F_3BCD;

/// x^y within four units in the last place. Where x is no positive normal number, or the result would come near an
/// end of the numbers' range, it is `libm`'s.
#[inline]
pub(crate) fn power(x: f64, y: f64) -> f64 {
    let bits = x.to_bits();
    // Neither zero nor what is not normal, negative, infinite or no number; no comparison is true for NaN.
    let is_usual = bits.wrapping_sub(1 << 52) < (2046 << 52) && y.abs() < 1e9;
    if !is_usual {
        return libm::pow(x, y);
    }
    let e = ((bits.wrapping_sub(HALF_ROOT)) as i64) >> 52;
    let m = f64::from_bits(bits.wrapping_sub((e as u64) << 52));
    let (e, log) = (e as f64, log2(m));
    let z = y * (e + log);
    if z.abs() >= 1000.0 {
        return libm::pow(x, y);
    }
    let whole = z + WHOLE;
    let n = whole - WHOLE;
    // The upper half of y's digits: its product with e is exact.
    let high = f64::from_bits(y.to_bits() & !0x07FF_FFFF);
    let rest = ((high * e - n) + (y - high) * e) + y * log;
    f64::from_bits(exp2(rest).to_bits().wrapping_add(whole.to_bits() << 52))
}

/// The binary logarithm on [1/sqrt(2), sqrt(2)).
#[inline(always)]
fn log2(m: f64) -> f64 {
    const TWO_OVER_LN2: f64 = 2.0 * core::f64::consts::LOG2_E;
    let s = (m - 1.0) / (m + 1.0);
    let q = s * s;
    let qq = q * q;
    let qqqq = qq * qq;
    let low = (1.0 / 3.0 + q * (1.0 / 5.0)) + qq * (1.0 / 7.0 + q * (1.0 / 9.0));
    let high = (1.0 / 11.0 + q * (1.0 / 13.0)) + qq * (1.0 / 15.0 + q * (1.0 / 17.0));
    let series = low + qqqq * (high + qqqq * (1.0 / 19.0 + q * (1.0 / 21.0)));
    TWO_OVER_LN2 * (s + s * (q * series))
}

/// 2^f on about [-1/2, 1/2], by the exponential's series.
#[inline(always)]
fn exp2(f: f64) -> f64 {
    /// 1/n!.
    const C: [f64; 14] = {
        let mut c = [1.0; 14];
        let mut n = 1;
        while n < 14 {
            c[n] = c[n - 1] / n as f64;
            n += 1;
        }
        c
    };
    let g = f * core::f64::consts::LN_2;
    let gg = g * g;
    let gggg = gg * gg;
    let a = (C[2] + g * C[3]) + gg * (C[4] + g * C[5]);
    let b = (C[6] + g * C[7]) + gg * (C[8] + g * C[9]);
    let c = (C[10] + g * C[11]) + gg * (C[12] + g * C[13]);
    1.0 + (g + gg * (a + gggg * (b + gggg * c)))
}

#[cfg(test)]
mod tests {
    use super::power;

    /// `libm::pow` is within one unit in the last place of the true value; this is within three of it.
    #[test]
    fn it_is_the_power() {
        let mut worst: f64 = 0.0;
        for i in 0..200_000 {
            // Parts of irrational numbers, which fill the square evenly.
            let (a, b) = ((f64::from(i) * 0.754_877_666).fract(), (f64::from(i) * 0.569_840_290).fract());
            let x = libm::exp2(60.0 * (a - 0.8));
            let y = 6.0 * (b - 0.2);
            let (found, expected) = (power(x, y), libm::pow(x, y));
            worst = worst.max(((found - expected) / expected).abs());
            assert!(worst <= 4.0 * f64::EPSILON, "{x} ^ {y} = {found}, not {expected}");
        }
        assert!(worst > 0.0);
    }

    /// Ends of the range, and what is no positive number.
    #[test]
    fn ends_are_libms() {
        let odd = [0.0, -0.0, -1.5, 5e-324, 1e-310, f64::MIN_POSITIVE, f64::MAX, f64::INFINITY, f64::NAN, 1.0];
        for x in odd {
            for y in [0.0, 1.0, 1.7, -0.5, 3.0, 1e10, -1e300, f64::INFINITY, f64::NAN] {
                let (found, expected) = (power(x, y), libm::pow(x, y));
                let close = (found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs();
                assert!(
                    close || found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan(),
                    "{x} {y}"
                );
            }
        }
    }
}
