//! Numbers with a fixed number of decimals, written without an exponent and without a negative zero.

/// The powers of ten that are exact and that any number of a file needs.
pub(super) const POWERS_OF_TEN: [f64; 16] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// Below this adding and taking away [`TO_WHOLE`] leaves the nearest whole number, ties to even.
const ROUNDS_BELOW: f64 = 2_251_799_813_685_248.0;
/// 1.5 * 2^52: what is added to it loses everything behind the point.
const TO_WHOLE: f64 = 6_755_399_441_055_744.0;

/// As [`f64::round_ties_even`], which is a call where the processor's own rounding is not built in.
#[inline(always)]
fn round_even(value: f64) -> f64 {
    if value.abs() < ROUNDS_BELOW { ((value + TO_WHOLE) - TO_WHOLE).copysign(value) } else { value.round_ties_even() }
}

/// `value` rounded to `decimals` places, ties to even of the scaled value: what [`push_fixed`] will print.
#[inline(always)]
pub fn round_to(value: f64, decimals: u32) -> f64 {
    let scale = 10f64.powi(decimals as i32);
    round_even(value * scale) / scale
}

/// `value` in units of its last of `decimals` places: the whole number that [`push_units`] prints, [`round_to`] times a power of
/// ten.
///
/// # Panics
///
/// Panics where `value` is not finite or `|value| * 10^decimals` exceeds 2^53: no machine has such a coordinate, so it is
/// a bug upstream.
#[inline(always)]
pub fn units_of(value: f64, decimals: u32) -> i64 {
    let scaled = round_even(value * 10f64.powi(decimals as i32));
    assert!(scaled.abs() < 9.0e15, "{value} cannot be written with {decimals} decimals");
    scaled as i64
}

/// Appends `value` with at most `decimals` places; trailing zeros and a bare point are left out, `-0` becomes `0`.
///
/// # Panics
///
/// As [`units_of`].
#[inline(always)]
pub fn push_fixed(out: &mut Vec<u8>, value: f64, decimals: u32) {
    push_units(out, units_of(value, decimals), decimals);
}

/// Appends `units / 10^decimals` as [`push_fixed`] does.
// Inlined where `decimals` is known, so that nothing is really divided.
#[inline(always)]
pub fn push_units(out: &mut Vec<u8>, units: i64, decimals: u32) {
    if units < 0 {
        out.push(b'-');
    }
    let (units, scale) = (units.unsigned_abs(), 10u64.pow(decimals));
    let (whole, fraction) = (units / scale, units % scale);
    match usize::try_from(whole).ok().and_then(|whole| WHOLE.get(whole)) {
        Some(short) => push_short(out, *short),
        None => push_integer(out, whole),
    }
    match decimals {
        _ if fraction == 0 => {}
        1..=3 => push_short(out, FRACTION[(fraction * 10u64.pow(3 - decimals)) as usize]),
        4..=6 => {
            let fraction = fraction * 10u64.pow(6 - decimals);
            push_six(out, (fraction / 1000) as usize, (fraction % 1000) as usize);
        }
        _ => push_fraction(out, fraction, decimals),
    }
}

/// Up to four characters, and how many they are.
type Short = ([u8; 4], u8);

/// 0 to 999.
static WHOLE: [Short; 1000] = shorts(false);
/// A point and thousandths without trailing zeros; at 0 the point alone.
static FRACTION: [Short; 1000] = shorts(true);

const fn shorts(fraction: bool) -> [Short; 1000] {
    let mut all = [([0; 4], 0); 1000];
    let mut number = 0;
    while number < 1000 {
        let digits = [b'0' + (number / 100) as u8, b'0' + (number / 10 % 10) as u8, b'0' + (number % 10) as u8];
        let [a, b, c] = digits;
        all[number] = match (fraction, number) {
            (true, 0) => ([b'.', b'0', b'0', b'0'], 1),
            (true, n) => (
                [b'.', a, b, c],
                if n % 100 == 0 {
                    2
                } else if n % 10 == 0 {
                    3
                } else {
                    4
                },
            ),
            (false, 0..=9) => ([c, 0, 0, 0], 1),
            (false, 10..=99) => ([b, c, 0, 0], 2),
            (false, _) => ([a, b, c, 0], 3),
        };
        number += 1;
    }
    all
}

/// A copy of fixed size, the rest of it taken back: cheaper than one of a size that is known only now.
#[inline]
fn push_short(out: &mut Vec<u8>, (text, length): Short) {
    out.extend_from_slice(&text);
    out.truncate(out.len() - (4 - usize::from(length)));
}

/// Six decimals in two groups of three, without trailing zeros.
#[inline]
fn push_six(out: &mut Vec<u8>, high: usize, low: usize) {
    if low == 0 {
        return push_short(out, FRACTION[high]);
    }
    out.extend_from_slice(&FRACTION[high].0);
    let ([_, a, b, c], length) = FRACTION[low];
    push_short(out, ([a, b, c, 0], length - 1));
}

fn push_integer(out: &mut Vec<u8>, mut value: u64) {
    let mut digits = [0u8; 20];
    let mut at = digits.len();
    loop {
        at -= 1;
        digits[at] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[at..]);
}

fn push_fraction(out: &mut Vec<u8>, mut fraction: u64, decimals: u32) {
    let mut places = decimals as usize;
    while fraction.is_multiple_of(10) {
        fraction /= 10;
        places -= 1;
    }
    out.push(b'.');
    let start = out.len();
    out.resize(start + places, b'0');
    for place in out[start..].iter_mut().rev() {
        *place = b'0' + (fraction % 10) as u8;
        fraction /= 10;
    }
}

/// The number at the start of `input`, the first digit behind its point, and its length; `Some(None)` where none begins,
/// `None` for a sign or a point without a digit.
#[expect(clippy::option_option, reason = "no number is fine, half a number is not")]
pub(super) fn number(input: &[u8]) -> Option<Option<(f64, u8, usize)>> {
    let signed = usize::from(matches!(input.first(), Some(b'-' | b'+')));
    let digits = |from: usize| input[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let whole = &input[signed..signed + digits(signed)];
    let mut at = signed + whole.len();
    let pointed = input.get(at) == Some(&b'.');
    at += usize::from(pointed);
    let fraction = if pointed { &input[at..at + digits(at)] } else { &[] };
    at += fraction.len();
    if whole.is_empty() && fraction.is_empty() {
        return if at == 0 { Some(None) } else { None };
    }
    let minor = fraction.first().map_or(0, |digit| digit - b'0');
    Some(Some((decimal(input.first() == Some(&b'-'), whole, fraction), minor, at)))
}

/// The value of `whole.fraction`: exact as `str::parse` up to 15 digits, by way of it beyond.
fn decimal(negative: bool, whole: &[u8], fraction: &[u8]) -> f64 {
    let magnitude = if whole.len() + fraction.len() <= 15 {
        let mantissa = whole.iter().chain(fraction).fold(0u64, |m, digit| m * 10 + u64::from(digit - b'0'));
        mantissa as f64 / POWERS_OF_TEN[fraction.len()]
    } else {
        let text: String = whole.iter().chain(b".").chain(fraction).map(|&b| b as char).collect();
        text.parse().unwrap_or(f64::INFINITY)
    };
    if negative { -magnitude } else { magnitude }
}

#[cfg(test)]
mod tests {
    use super::{push_fixed, push_units, round_even, round_to, units_of};

    #[track_caller]
    fn check(value: f64, decimals: u32, wanted: &str) {
        let mut out = Vec::new();
        push_fixed(&mut out, value, decimals);
        assert_eq!(String::from_utf8(out).unwrap(), wanted);
    }

    #[test]
    fn writes_the_shortest_fixed_form() {
        check(1.5, 3, "1.5");
        check(-0.0004, 3, "0");
        check(-0.5, 3, "-0.5");
        check(12.0, 3, "12");
        check(0.001, 3, "0.001");
        check(-123.45678, 4, "-123.4568");
        check(100.0, 0, "100");
        check(0.10005, 5, "0.10005");
    }

    #[test]
    fn rounds_as_it_prints() {
        assert_eq!(round_to(1.23456, 3), 1.235);
        assert_eq!(round_to(-0.0004, 3), 0.0);
    }

    #[test]
    fn any_number_is_printed_as_the_standard_library_does_without_trailing_zeros() {
        let mut state = 1u64;
        for round in 0..200_000u32 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let (decimals, size) = (round % 8, [1000, 1_000_000, 10_000_000_000_000][round as usize % 3]);
            let units = (state >> 11) as i64 % size - size / 2;
            let scale = 10u64.pow(decimals);
            let magnitude = units.unsigned_abs();
            let places = decimals as usize;
            let mut wanted = format!("{}.{:0places$}", magnitude / scale, magnitude % scale);
            wanted = wanted.trim_end_matches('0').trim_end_matches('.').to_owned();
            if places == 0 {
                wanted = magnitude.to_string();
            }
            if units < 0 {
                wanted.insert(0, '-');
            }
            let mut out = Vec::new();
            push_units(&mut out, units, decimals);
            assert_eq!(String::from_utf8(out).unwrap(), wanted);
            let value = units as f64 / scale as f64;
            assert_eq!(units_of(value, decimals), units, "{value}");
            check(value, decimals, &wanted);
        }
    }

    #[test]
    fn rounding_is_that_of_the_standard_library_to_the_bit() {
        let mut state = 5u64;
        for _ in 0..200_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let any = f64::from_bits(state);
            let near = (state >> 20) as f64 / 1024.0 - 2e9;
            let tie = ((state >> 30) as f64 - 8e9) + 0.5;
            for value in [any, near, tie, -tie, 0.0, -0.0, -0.3, 0.5, 1.5, -2.5] {
                let (found, wanted) = (round_even(value), value.round_ties_even());
                assert!(found.to_bits() == wanted.to_bits() || value.is_nan(), "{value}: {found} for {wanted}");
            }
        }
    }
}
