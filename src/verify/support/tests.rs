//! What hangs: loops, bridges, ledges, rings and supports, laid on a field of walls.

use super::super::acts::Kind;
use super::super::field::Rect;
use super::*;

const WIDTH: f32 = 0.45;
const HEIGHT: f32 = 0.2;
const BRIDGE_MM: f64 = 14.0;

/// The stretches that are too long of a line through these places, 10 mm up, over two walls along y at `walls` (x from and to).
fn too_long(walls: &[[f64; 2]], way: &[[f64; 2]]) -> Vec<f64> {
    all_too_long(walls, &[way.to_vec()])
}

/// The same of several lines.
fn all_too_long(walls: &[[f64; 2]], ways: &[Vec<[f64; 2]>]) -> Vec<f64> {
    too_long_of(walls, ways, usize::MAX)
}

/// The same, all but the first `lower` of them a layer above the others.
fn too_long_of(walls: &[[f64; 2]], ways: &[Vec<[f64; 2]>], lower: usize) -> Vec<f64> {
    let mut field = Field::new(&Rect { min: [-40.0; 2], max: [40.0; 2] });
    for [from, to] in walls {
        let lines = ((to - from) / 0.2).round() as usize;
        let at = |k: usize| from + (to - from) * (k as f64 + 0.5) / lines as f64;
        (0..lines).for_each(|k| field.deposit([[at(k), -30.0], [at(k), 30.0]], 0.3, 10.0 - f64::from(HEIGHT)));
    }
    laid(field, ways, lower)
}

/// The same over whatever is in `field`.
fn laid(mut field: Field, ways: &[Vec<[f64; 2]>], lower: usize) -> Vec<f64> {
    field.settle();
    let (mut laying, mut found) = (Laying::new(BRIDGE_MM), Vec::new());
    for (k, way) in ways.iter().enumerate() {
        let z = if k < lower { 10.0 } else { 10.0 + f64::from(HEIGHT) };
        for ends in way.windows(2) {
            let [from, to] = [ends[0], ends[1]].map(|[x, y]| Vec3::new(x, y, z));
            let stroke = Stroke { from, to, line: 1, print: None, kind: Kind::Print, width: WIDTH, height: HEIGHT };
            laying.lay(&stroke, &mut field, &mut found);
        }
        laying.end(&mut field, &mut found);
    }
    laying.settle(&mut found);
    found.iter().map(|gap| gap.length).collect()
}

/// Walls on both sides of a gap so wide.
fn gap(wide: f64) -> [[f64; 2]; 2] {
    [[-wide / 2.0 - 8.0, -wide / 2.0], [wide / 2.0, wide / 2.0 + 8.0]]
}

/// What hangs of these lines in a square well so wide, half of that, with walls all around.
fn in_a_well(half: f64, ways: &[Vec<[f64; 2]>]) -> usize {
    let mut field = Field::new(&Rect { min: [-40.0; 2], max: [40.0; 2] });
    let mut wall = |ends: [[f64; 2]; 2]| field.deposit(ends, 0.3, 10.0 - f64::from(HEIGHT));
    for k in 0..50 {
        let out = half + (f64::from(k) + 0.5) * 0.2;
        for at in [-out, out] {
            wall([[at, -30.0], [at, 30.0]]);
            wall([[-30.0, at], [30.0, at]]);
        }
    }
    laid(field, ways, usize::MAX).len()
}

/// A ring around, from the middle of its side along x.
fn ring([x, y]: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[0.0, -y], [x, -y], [x, y], [-x, y], [-x, -y], [0.0, -y]]
}

#[test]
fn a_loop_that_begins_over_a_gap_spans_it_once() {
    // From wall to wall, twice, and begun in the middle of the gap.
    assert_eq!(too_long(&gap(13.0), &ring([10.0, 3.0])), Vec::<f64>::new());
    // The same line, not closed, has two ends in the air.
    let open = ring([10.0, 3.0]).into_iter().take(5).chain([[-1.0, -3.0]]).collect::<Vec<_>>();
    assert_eq!(too_long(&gap(13.0), &open).len(), 2);
    // Too wide: both spans are.
    let found = too_long(&gap(18.0), &ring([14.0, 3.0]));
    assert!(found.len() == 2 && found.iter().all(|mm| *mm > 15.0), "{found:?}");
}

#[test]
fn a_ring_that_touches_nothing_but_itself_lies_on_nothing() {
    for half in [0.6, 0.9, 1.5, 3.0] {
        let found = too_long(&gap(30.0), &ring([half, half]));
        assert!(found.len() == 1 && found[0] > 2.0, "{half}: {found:?}");
    }
}

/// A floor in the middle of a layer is printed a layer lower by some slicers, and they leave air below their own supports, too.
#[test]
fn supports_stand_on_a_part_with_as_much_air_as_above_them() {
    let layer = f64::from(HEIGHT);
    let hangs = |layers: u32, gap_mm: f64, holds: bool| {
        let mut field = Field::new(&Rect { min: [-40.0; 2], max: [40.0; 2] });
        let top = 10.0 - layer * f64::from(layers + 1);
        field.settle();
        let at = |k: i32| f64::from(k) * 0.3 - 6.0;
        (0..40).for_each(|k| field.deposit([[at(k), -30.0], [at(k), 30.0]], 0.3, top));
        let (mut laying, mut gaps) = (Laying::new(BRIDGE_MM), Vec::new());
        laying.with_supports(gap_mm, holds);
        let [from, to] = [-10.0, 10.0].map(|y| Vec3::new(0.0, y, 10.0));
        let stroke = Stroke { from, to, line: 1, print: None, kind: Kind::Print, width: WIDTH, height: HEIGHT };
        laying.lay(&stroke, &mut field, &mut gaps);
        laying.end(&mut field, &mut gaps);
        laying.settle(&mut gaps);
        !gaps.is_empty()
    };
    for (layers, gap_mm, found) in [(0, 0.2, false), (1, 0.2, false), (2, 0.2, true), (1, 0.0, true), (2, 0.3, false)] {
        assert_eq!(hangs(layers, gap_mm, true), found, "{layers} layers of air, gap {gap_mm}");
        assert_eq!(hangs(layers, 0.0, false), layers > 0, "a part with {layers} layers of air");
    }
}

/// A hole above a counterbore: the loop comes first, then what holds it.
#[test]
fn a_ring_is_held_by_what_its_layer_lays_after_it() {
    let walls = gap(9.0);
    let ring = || ring([2.0, 2.0]);
    // From wall to wall beside it, and from both walls to it.
    let across: Vec<Vec<[f64; 2]>> = [-2.4, 2.4].map(|y| vec![[-7.0, y], [7.0, y]]).to_vec();
    let left = |y: f64| vec![[-7.0, y], [-2.1, y]];
    let right = |y: f64| vec![[2.1, y], [7.0, y]];
    let spokes = |of: &dyn Fn(f64) -> Vec<[f64; 2]>| [-1.5, -0.5, 0.5, 1.5].map(of).to_vec();
    let whole = [vec![ring()], across.clone(), spokes(&left), spokes(&right)].concat();
    assert_eq!(all_too_long(&walls, &whole), Vec::<f64>::new());
    // A second ring around it, which the bridges meet.
    let outer = vec![[0.0, -2.4], [2.4, -2.4], [2.4, 2.4], [-2.4, 2.4], [-2.4, -2.4], [0.0, -2.4]];
    let far: Vec<Vec<[f64; 2]>> = [-2.8, 2.8].map(|y| vec![[-7.0, y], [7.0, y]]).to_vec();
    assert_eq!(all_too_long(&walls, &[vec![ring(), outer], far].concat()), Vec::<f64>::new());
    // From one side alone, or beyond its layer's end, it is not.
    let one_side = [vec![ring()], spokes(&left)].concat();
    assert_eq!(all_too_long(&walls, &one_side).len(), 1);
    // The filling of a disc in the air, which has nothing but the ring; as wide as it may be.
    for half in [1.0, 2.0, 4.0] {
        let lines = (0..(half * 4.0) as usize).map(|k| -half + 0.25 + 0.45 * k as f64).filter(|y| *y < half);
        let filling = lines.map(|y| vec![[-half, y], [half, y]]);
        let disc: Vec<Vec<[f64; 2]>> = std::iter::once(super::tests::ring([half, half])).chain(filling).collect();
        assert_eq!(all_too_long(&gap(30.0), &disc).len(), 1, "{half}");
    }
    // The same in one line, row after row, each beside the one before: nothing but itself.
    for half in [1.0, 2.0, 3.0, 4.0, 5.0] {
        let rows = (0..(half * 4.0) as usize).map(|k| -half + 0.25 + 0.45 * k as f64).filter(|y| *y < half);
        let rows: Vec<f64> = rows.collect();
        let turn = |k: usize, y: f64| {
            let ends = [[-half, y], [half, y]];
            if k.is_multiple_of(2) { ends } else { [ends[1], ends[0]] }
        };
        let zigzag = rows.iter().enumerate().flat_map(|(k, y)| turn(k, *y)).collect();
        let disc = [super::tests::ring([half, half]), zigzag];
        assert_eq!(all_too_long(&gap(30.0), &disc).len(), 1, "{half}");
        // On a wall at one end of its rows it lies on something, and holds the ring where it meets it: from one side.
        let far: Vec<[f64; 2]> =
            disc[1].iter().map(|[x, y]| [if *x < 0.0 { -20.0 } else { -half - 0.1 }, *y]).collect();
        assert_eq!(all_too_long(&gap(30.0), &[disc[0].clone(), far]).len(), 1, "{half}");
    }
    // What the next layer lays comes too late.
    assert_eq!(too_long_of(&walls, &[vec![ring()], across, spokes(&left), spokes(&right)].concat(), 1).len(), 1);
    // A ring too large to be held so.
    let large = [vec![super::tests::ring([6.0, 6.0])], vec![vec![[-20.0, 6.4], [20.0, 6.4]]]].concat();
    assert!(!all_too_long(&gap(13.0), &large).is_empty());
}

/// A tab that goes out from a wall into the air: its outline hangs for more than half of itself, and what fills it begins on the wall.
#[test]
fn what_fills_an_outline_does_not_hold_it() {
    for mm in [3.0, 4.0, 6.0, 10.0, 20.0] {
        let outline = vec![[-1.0, 0.0], [-1.0, -3.0], [mm, -3.0], [mm, 3.0], [-1.0, 3.0], [-1.0, 0.0]];
        let turn = |k: usize, ends: [[f64; 2]; 2]| if k.is_multiple_of(2) { ends } else { [ends[1], ends[0]] };
        // Row by row out and back, in one line or in several; or across, farther and farther out.
        let out: Vec<[[f64; 2]; 2]> =
            (0..13).map(|k| (k, -2.6 + 0.43 * k as f64)).map(|(k, y)| turn(k, [[-4.0, y], [mm - 0.4, y]])).collect();
        let count = ((mm + 4.0) / 0.43) as usize;
        let across: Vec<[f64; 2]> =
            (0..count).map(|k| (k, -4.0 + 0.43 * k as f64)).flat_map(|(k, x)| turn(k, [[x, -2.6], [x, 2.6]])).collect();
        let joined = vec![out.concat()];
        let rows = out.iter().map(|row| row.to_vec()).collect();
        for filling in [joined, rows, vec![across]] {
            let found = all_too_long(&[[-8.0, 0.0]], &[vec![outline.clone()], filling].concat());
            assert!(!found.is_empty(), "{mm}");
        }
    }
}

#[test]
fn what_turns_over_air_is_no_bridge() {
    // Out from a wall, along, and back.
    let out = |mm: f64, wide: f64| {
        let (wall, end) = (-15.0 - 2.0, -15.0 + mm);
        vec![[wall, 0.0], [end, 0.0], [end, wide], [wall, wide]]
    };
    assert_eq!(too_long(&gap(30.0), &out(2.0, 3.0)), Vec::<f64>::new());
    let found = too_long(&gap(30.0), &out(2.6, 8.0));
    assert!(found.len() == 1 && found[0] > TURNED_MM && found[0] < BRIDGE_MM, "{found:?}");
    // As much in one direction is one.
    assert_eq!(too_long(&gap(12.0), &[[-10.0, 0.0], [10.0, 0.0]]), Vec::<f64>::new());
}

/// PrusaSlicer 2.9 does not warn of ledges 2 mm wide along 16 mm, nor of those 1.5 mm wide along 25 mm.
#[test]
fn the_rim_of_a_narrow_ledge_turns_over_air() {
    let rim = |out: f64, long: f64| vec![[-4.0, 0.0], [out, 0.0], [out, long], [-4.0, long]];
    let wall = [[-12.0, 0.0]];
    for (out, long, found) in [
        (1.2, 15.0, 0),
        (1.2, 25.0, 0),
        (1.2, 29.0, 0),
        (1.65, 25.0, 1),
        (1.7, 12.0, 0),
        (1.7, 15.0, 0),
        (1.7, 18.0, 1),
        (2.6, 12.0, 1),
        (2.6, 4.0, 0),
        (6.0, 4.0, 1),
    ] {
        assert_eq!(too_long(&wall, &rim(out, long)).len(), found, "out by {out} mm along {long} mm");
        // The same as a part of an outline that begins on the ledge, or beside it.
        let around =
            |from: [f64; 2]| [vec![from, [out, long], [-10.0, long], [-10.0, 0.0], [out, 0.0]], vec![from]].concat();
        assert_eq!(too_long(&wall, &around([out, long / 2.0])).len(), found, "a closed line, {out} and {long} mm");
    }
    // A thin tab's way back is not held by its way out.
    assert_eq!(too_long(&wall, &rim(7.0, 1.0)).len(), 1);
}

/// The roof of a hole with a notch in its side: the outline goes around the notch over air, and then bridges run beside it.
#[test]
fn what_turns_over_air_is_held_by_bridges_beside_it() {
    let walls = gap(9.0);
    let notch = vec![[-7.0, -2.5], [-3.0, -2.5], [-3.0, 0.5], [3.0, 0.5], [3.0, -2.5], [7.0, -2.5]];
    assert_eq!(too_long(&walls, &notch).len(), 1);
    let rows = |from: f64, to: f64| -> Vec<Vec<[f64; 2]>> { [0.95, 1.4].map(|y| vec![[from, y], [to, y]]).to_vec() };
    let zigzag = vec![vec![[-7.0, 0.95], [7.0, 0.95], [7.0, 1.4], [-7.0, 1.4]]];
    for (bridges, found) in [(rows(-7.0, 7.0), 0), (zigzag, 0), (rows(-7.0, 2.0), 1), (rows(-3.0, 3.0), 1)] {
        assert_eq!(all_too_long(&walls, &[vec![notch.clone()], bridges.clone()].concat()).len(), found, "{bridges:?}");
    }
    // What the next layer lays comes too late; and a notch of which a side is too far from the bridges is not held.
    assert_eq!(too_long_of(&walls, &[vec![notch.clone()], rows(-7.0, 7.0)].concat(), 1).len(), 1);
    let deep: Vec<[f64; 2]> = notch.iter().map(|[x, y]| [*x, if *y < 0.0 { -8.5 } else { *y }]).collect();
    assert!(!all_too_long(&walls, &[vec![deep], rows(-7.0, 7.0)].concat()).is_empty());
    // A tab's rows, out and back, hold nothing: neither in one line nor in many.
    let tab = vec![[-1.0, -3.0], [6.0, -3.0], [6.0, 3.0], [-1.0, 3.0]];
    let out: Vec<[[f64; 2]; 2]> = (0..13).map(|k| -2.6 + 0.43 * f64::from(k)).map(|y| [[-4.0, y], [5.6, y]]).collect();
    let one = out.iter().enumerate().flat_map(|(k, [a, b])| if k % 2 == 0 { [*a, *b] } else { [*b, *a] }).collect();
    for filling in [vec![one], out.iter().map(|row| row.to_vec()).collect()] {
        assert!(!all_too_long(&[[-8.0, 0.0]], &[vec![tab.clone()], filling].concat()).is_empty());
    }
}

#[test]
fn small_patches_go_out_farther_than_a_line_stays_up() {
    let wall = [[-8.0, 0.0]];
    // So many lines out from the wall, too far from each other to carry one another, begun on it and, every second one, in the air.
    let comb = |count: usize, mm: f64, from: f64| -> Vec<Vec<[f64; 2]>> {
        let line = |k: usize| {
            let y = from + k as f64;
            let way = [[-4.0, y], [mm, y]];
            if k.is_multiple_of(2) { way.to_vec() } else { way.into_iter().rev().collect() }
        };
        (0..count).map(line).collect()
    };
    // What the wall's cells reach beyond it.
    let out = |mm: f64| mm + 0.3;
    for (count, mm, found) in [
        (1, 1.9, 0),
        (30, 1.9, 0),
        (1, 2.5, 0),
        (6, 2.5, 0),
        (8, 2.5, 0),
        (14, 2.5, 14),
        (20, 2.5, 20),
        (6, 2.9, 0),
        (12, 2.9, 12),
        (1, 3.8, 1),
        (3, 3.8, 3),
    ] {
        assert_eq!(all_too_long(&wall, &comb(count, out(mm), -10.0)).len(), found, "{count} lines out by {mm} mm");
    }
    // Two patches, each small, with a gap between them; and as one, with short lines in it.
    let two = |middle: Vec<Vec<[f64; 2]>>| [comb(6, out(2.5), -12.0), middle, comb(6, out(2.5), -2.0)].concat();
    assert_eq!(all_too_long(&wall, &two(Vec::new())).len(), 0);
    assert_eq!(all_too_long(&wall, &two(comb(4, out(1.5), -6.0))).len(), 12);
}

#[test]
fn a_patch_is_of_one_layer_whatever_lies_in_between() {
    // Lines out by 2.5 mm, the height of each so much above the one before, back and forth.
    let patch = |apart: f64| {
        let mut field = Field::new(&Rect { min: [-40.0; 2], max: [40.0; 2] });
        (0..40).for_each(|k| {
            field.deposit([[-8.0 + 0.2 * f64::from(k), -30.0], [-8.0 + 0.2 * f64::from(k), 30.0]], 0.3, 9.8)
        });
        field.settle();
        let (mut laying, mut found) = (Laying::new(BRIDGE_MM), Vec::new());
        for k in 0..14 {
            let at = |x: f64| Vec3::new(x, f64::from(k), 10.0 + apart * f64::from(k % 2));
            let stroke = Stroke {
                from: at(-4.0),
                to: at(2.8),
                line: 1,
                print: None,
                kind: Kind::Print,
                width: WIDTH,
                height: HEIGHT,
            };
            laying.lay(&stroke, &mut field, &mut found);
            laying.end(&mut field, &mut found);
        }
        laying.settle(&mut found);
        found.len()
    };
    assert_eq!([0.0, 1e-6, 0.01].map(patch), [14; 3]);
}

/// PrusaSlicer 2.9 lays the rim of a bore that is narrower above before what holds it, and does not warn of it.
#[test]
fn the_rim_of_a_bore_is_held_however_long_it_is_by_what_comes_around_it() {
    let rings = |halves: &[f64]| halves.iter().map(|half| ring([*half; 2])).collect::<Vec<_>>();
    // 1 mm out, 72 mm long: alone, with something inside it alone, and with all of its ledge.
    assert_eq!(in_a_well(10.0, &rings(&[9.0])), 1);
    assert_eq!(in_a_well(10.0, &rings(&[9.0, 8.6])), 1);
    assert_eq!(in_a_well(10.0, &rings(&[9.0, 9.45, 9.85])), 0);
    // Farther out than lines hang free it is no rim.
    assert_eq!(in_a_well(10.0, &rings(&[7.3, 7.75, 8.2, 8.65, 9.1, 9.5, 9.9])), 1);
}
