//! Letters as strokes, for pictures in dots: those of ASCII, drawn for this program on a grid of five by ten.
//!
//! A glyph is its strokes with a space between; a stroke is pairs of digits, across (0 to 4) and up (0 to 9; the base line is at 2,
//! capitals end at 8). A place by itself twice is a dot. What has no glyph is a box.

/// From the space to the tilde.
const GLYPHS: [&str; 95] = [
    "",
    "2824 2222",
    "1816 3836",
    "1218 3238 0444 0646",
    "473818070615354443321203 2921",
    "0248 0818170708 3343423233",
    "42161728370403122244",
    "2826",
    "38262432",
    "18262412",
    "2723 1436 1634",
    "2723 0545",
    "2311",
    "1535",
    "2222",
    "0248",
    "28373322131728",
    "172822 1232",
    "07183847460242",
    "07183847463515 354443321203",
    "32380444",
    "480805354443321203",
    "38180703123243443505",
    "084812",
    "183847463515060718 1504031232434435",
    "12324347381807061545",
    "2222 2525",
    "2525 2311",
    "471543",
    "0646 0444",
    "073503",
    "071838474624 2222",
    "4336262434454738180703123242",
    "022842 1434",
    "02083847463505 3544433202",
    "4738180703123243",
    "02082846442202",
    "48080242 0535",
    "480802 0535",
    "47381807031232434525",
    "0208 4248 0545",
    "1232 1838 2228",
    "4843321203",
    "0208 0448 1542",
    "080242",
    "0208254842",
    "02084248",
    "183847433212030718",
    "02083847463505",
    "183847433212030718 2442",
    "02083847463505 2542",
    "473818070615354443321203",
    "0848 2822",
    "080312324348",
    "082248",
    "0812253248",
    "0842 0248",
    "082548 2522",
    "08480242",
    "38282232",
    "0842",
    "18282212",
    "162836",
    "0141",
    "1827",
    "16364542 441403123243",
    "0802 0516364543321203",
    "4536160503123243",
    "4842 4536160503123243",
    "044445361605031232",
    "48382722 1636",
    "46413010 4536160503123243",
    "0802 0516364542",
    "2622 2828",
    "36312010 3838",
    "0802 0446 2542",
    "18282332",
    "0602 05162522 25364542",
    "0602 0516364542",
    "163645433212030516",
    "0600 0516364543321203",
    "4640 4536160503123243",
    "0602 042646",
    "45361605143443321203",
    "28233242 1636",
    "0603123243 4642",
    "062246",
    "0612243246",
    "0642 0246",
    "0622 4610",
    "06460242",
    "38272615242332",
    "2820",
    "18272635242312",
    "05163445",
];
const BOX: &str = "0208484202";

/// A step of the grid across and up, and from letter to letter, in heights of the type.
const STEP: [f64; 2] = [0.1, 0.12];
const ADVANCE: f64 = 0.55;

/// How wide `text` is in this type.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    ADVANCE * size * text.chars().count() as f64
}

/// The strokes of `text` from `at`, its left end on the base line, y down.
pub(super) fn strokes(text: &str, [x, y]: [f64; 2], size: f64) -> Vec<Vec<[f64; 2]>> {
    let mut all = Vec::new();
    for (i, letter) in text.chars().enumerate() {
        let index = u32::from(letter).wrapping_sub(u32::from(' ')) as usize;
        let from = x + ADVANCE * size * i as f64;
        for stroke in GLYPHS.get(index).unwrap_or(&BOX).split_whitespace() {
            let digit = |byte: u8| f64::from(byte - b'0');
            let place = |pair: &[u8]| {
                [from + STEP[0] * size * (digit(pair[0]) + 0.5), y - STEP[1] * size * (digit(pair[1]) - 2.0)]
            };
            all.push(stroke.as_bytes().chunks_exact(2).map(place).collect());
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_glyph_is_on_the_grid_and_like_no_other() {
        for (i, glyph) in GLYPHS.iter().chain([&BOX]).enumerate() {
            for stroke in glyph.split_whitespace() {
                assert!(stroke.len() % 2 == 0 && stroke.len() >= 4 || stroke.len() == 2, "{glyph}");
                let pairs = stroke.as_bytes().chunks_exact(2);
                assert!(pairs.clone().all(|p| (b'0'..=b'4').contains(&p[0]) && p[1].is_ascii_digit()), "{glyph}");
            }
            assert!(i == 95 || GLYPHS[..i].iter().all(|other| other != glyph), "{glyph} twice");
        }
        assert_eq!(strokes("\u{17c}", [0.0; 2], 10.0).len(), 1, "what is not known is a box");
        assert!(strokes("A", [0.0; 2], 10.0).iter().flatten().all(|p| p[1] <= 0.0 && p[1] > -8.0));
    }
}
