//! `tanh` for sums over many facets: plain numbers, no unit. The rational function near 0 is that of Cephes (S. L. Moshier).

/// From here on `tanh` is 1 to the last digit.
const FAR: f64 = 19.0;

/// Up to here a short series does.
const SMALL: f64 = 0.05;

/// 0.6245 squared: up to here the rational function is right to the last digits but one.
const NEAR: f64 = 0.39;

/// `1 + tanh x`, without the cancellation where it is small.
pub(super) fn one_and_tanh(x: f64) -> f64 {
    if x.abs() < SMALL {
        let x2 = x * x;
        return 1.0 + x * (1.0 - x2 * (1.0 / 3.0 - x2 * (2.0 / 15.0 - x2 * (17.0 / 315.0 - x2 * 62.0 / 2835.0))));
    }
    if x > FAR { 2.0 } else { 2.0 / (1.0 + (-2.0 * x).exp()) }
}

/// `tanh x` by one exponential at most, and by none near 0 and far from it.
pub(super) fn tanh(x: f64) -> f64 {
    let x2 = x * x;
    if x2 < NEAR {
        let above = (-9.643_991_794_250_522e-1 * x2 - 9.928_772_310_019_186e1) * x2 - 1.614_687_684_417_084_5e3;
        let below = ((x2 + 1.128_116_784_916_329_3e2) * x2 + 2.235_488_390_601_004_5e3) * x2 + 4.844_063_053_251_255e3;
        return x + x * x2 * (above / below);
    }
    if x > FAR { 1.0 } else { 1.0 - 2.0 / (1.0 + (2.0 * x).exp()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_are_the_librarys_but_for_the_last_digits() {
        for i in -30_000..=30_000 {
            // Closer together near 0.
            let x = 25.0 * (f64::from(i) / 30_000.0).powi(3);
            let one = 2.0 * (2.0 * x).exp() / (1.0 + (2.0 * x).exp());
            assert!((tanh(x) - x.tanh()).abs() <= 4e-16 * if x.abs() < 0.6 { x.abs() } else { 1.0 }, "{x}");
            assert!((one_and_tanh(x) - one).abs() <= 2e-14 * one, "{x}");
        }
        assert_eq!((tanh(-800.0), tanh(800.0), one_and_tanh(-800.0), one_and_tanh(800.0)), (-1.0, 1.0, 0.0, 2.0));
    }
}
