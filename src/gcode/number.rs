//! Numbers with a fixed number of decimals, written without an exponent and without a negative zero.

/// `value` rounded to `decimals` places, ties to even of the scaled value: what [`push_fixed`] will print.
pub fn round_to(value: f64, decimals: u32) -> f64 {
    let scale = 10f64.powi(decimals as i32);
    (value * scale).round_ties_even() / scale
}

/// Appends `value` with at most `decimals` places; trailing zeros and a bare point are left out, `-0` becomes `0`.
///
/// # Panics
///
/// Panics where `value` is not finite or `|value| * 10^decimals` exceeds 2^53: no machine has such a coordinate, so it is
/// a bug upstream.
pub fn push_fixed(out: &mut Vec<u8>, value: f64, decimals: u32) {
    let scale = 10u64.pow(decimals);
    let scaled = (value * scale as f64).round_ties_even();
    assert!(scaled.abs() < 9.0e15, "{value} cannot be written with {decimals} decimals");
    if scaled < 0.0 {
        out.push(b'-');
    }
    let units = scaled.abs() as u64;
    push_integer(out, units / scale);
    push_fraction(out, units % scale, decimals);
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
    if fraction == 0 {
        return;
    }
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

#[cfg(test)]
mod tests {
    use super::{push_fixed, round_to};

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
}
