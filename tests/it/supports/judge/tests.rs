//! The judge against supports made by hand, whose figures are known beforehand; and each figure against a fault that grows.

use super::{Layer, Line, Ruler, Triangle, supports};

const RULER: Ruler = Ruler { pitch_mm: 2.5, line_mm: 0.4, layer_mm: 0.2, overhang_deg: 45.0 };
/// The edge of a level ceiling, and its height, mm.
const EDGE_MM: f64 = 10.0;
const HIGH_MM: f64 = 10.0;

/// Two triangles that face down.
fn ceiling() -> Vec<Triangle> {
    let at = |x: f64, y: f64| [x * EDGE_MM, y * EDGE_MM, HIGH_MM];
    vec![[at(0.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)], [at(0.0, 0.0), at(1.0, 1.0), at(1.0, 0.0)]]
}

fn line(from: [f64; 2], to: [f64; 2]) -> Line {
    let mm3 = (to[0] - from[0]).hypot(to[1] - from[1]) * RULER.line_mm * RULER.layer_mm;
    Line { from, to, mm3 }
}

/// So many walls along x, a pitch apart, of so many layers.
fn walls(count: usize, layers: usize) -> Vec<Layer> {
    let of = |k: usize| {
        let y = RULER.pitch_mm * (k as f64 + 0.5);
        line([0.0, y], [EDGE_MM, y])
    };
    let layer = |i: usize| Layer { top_mm: RULER.layer_mm * (i + 1) as f64, lines: (0..count).map(of).collect() };
    (0..layers).map(layer).collect()
}

/// A layer below the ceiling is left free, as everybody leaves it.
const FULL: usize = 49;

#[test]
fn walls_below_a_ceiling_have_the_figures_of_their_lines() {
    let measures = RULER.measure(&ceiling(), &walls(4, FULL));
    let area = 4.0 * EDGE_MM * RULER.line_mm;
    assert!((measures.volume_mm3 - area * RULER.layer_mm * FULL as f64).abs() < 1e-6, "{measures:?}");
    assert_eq!((measures.covered, measures.bare_squares, measures.alone_mm), (1.0, 0, 0.0));
    // Within a sample's and a cell's grain; the ends of a line are round.
    assert!((measures.contact_mm2 / area - 1.0).abs() < 0.15, "{measures:?}");
    assert!((measures.plate_mm2 / area - 1.0).abs() < 0.05, "{measures:?}");
    assert!((measures.widest_mm - 1.25).abs() < 0.15, "{measures:?}");
}

#[test]
fn every_wall_less_is_a_quarter_bare() {
    for count in 0..=4 {
        let measures = RULER.measure(&ceiling(), &walls(count, FULL));
        assert!((measures.covered - count as f64 / 4.0).abs() < 0.03, "{count}: {measures:?}");
        assert_eq!(measures.bare_squares, 4 * (4 - count), "{count}: {measures:?}");
    }
}

#[test]
fn what_ends_too_low_holds_nothing() {
    // Half a pitch and two layers: 1.65 mm.
    for missing in 0..20 {
        let measures = RULER.measure(&ceiling(), &walls(4, FULL - missing));
        let air_mm = HIGH_MM - RULER.layer_mm * (FULL - missing) as f64;
        assert_eq!(measures.covered, if air_mm < 1.65 { 1.0 } else { 0.0 }, "{air_mm} mm of air");
        assert_eq!(measures.contact_mm2 > 0.0, air_mm < 0.41, "{air_mm} mm of air");
    }
}

/// Two posts, with a tie from one to the other in every so many layers.
#[test]
fn a_column_is_alone_between_what_ties_it_to_others() {
    let posts = |every: usize| -> Vec<Layer> {
        let post = |x: f64| [line([x - 1.0, 4.0], [x + 1.0, 6.0]), line([x - 1.0, 6.0], [x + 1.0, 4.0])];
        let layer = |i: usize| {
            let tie = (every > 0 && (i + 1).is_multiple_of(every)).then(|| line([1.0, 5.0], [9.0, 5.0]));
            let lines = post(1.0).into_iter().chain(post(9.0)).chain(tie).collect();
            Layer { top_mm: RULER.layer_mm * (i + 1) as f64, lines }
        };
        (0..FULL).map(layer).collect()
    };
    for every in [0, 2, 5, 10, 25] {
        let wanted = RULER.layer_mm * if every == 0 { FULL as f64 } else { (every - 1) as f64 };
        let found = RULER.measure(&ceiling(), &posts(every)).alone_mm;
        assert!((found - wanted).abs() < 1e-6, "a tie every {every} layers: {found} mm, {wanted} mm is right");
    }
}

/// The same lines in the words of three programs.
#[test]
fn lines_are_read_however_filament_is_counted() {
    let absolute = "M82\nG92 E0\nG1 X0 Y0 Z0.2\n;TYPE:Support material\nG1 X10 Y0 E1\n;TYPE:Perimeter\nG1 X10 Y9 E5\nG92 E0\n\
                    ;TYPE:Support material interface\nG1 X0 Y9 E2\nG1 E1\nG1 E2\n";
    let relative = "M83\nG1 X0 Y0 Z0.2\n;TYPE:SUPPORT\nG1 X10 E1\n;TYPE:WALL-INNER\nG1 Y9 E4\n;TYPE:SUPPORT-INTERFACE\nG1 X0 E2\nG1 E-1\nG0 X5\n";
    for text in [absolute, relative] {
        let layers = supports(text, 1.75);
        assert_eq!(layers.len(), 1);
        let volume: f64 = layers[0].lines.iter().map(|line| line.mm3).sum();
        assert!((volume - 3.0 * std::f64::consts::PI * 1.75 * 1.75 / 4.0).abs() < 1e-9, "{volume}");
        assert_eq!((layers[0].top_mm, layers[0].lines.len()), (0.2, 2));
        assert_eq!((layers[0].lines[1].from, layers[0].lines[1].to), ([10.0, 9.0], [0.0, 9.0]));
    }
}
