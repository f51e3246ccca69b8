//! Layers that are small: how long they take, and that they are full.

use super::*;

/// For each layer what its moves take at the speeds of the file, s, and the fastest that it prints, mm/s.
fn layer_times(gcode: &str) -> Vec<[f64; 2]> {
    let (mut at, mut feed, mut layers) = ([f64::NAN; 2], 0.0, Vec::new());
    for line in gcode.lines() {
        if line.starts_with(";LAYER_CHANGE") {
            layers.push([0.0, 0.0]);
        }
        let Some(rest) = line.strip_prefix("G1 ") else { continue };
        let word = |letter: char| rest.split(' ').find_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
        feed = word('F').unwrap_or(feed) / if word('F').is_some() { 60.0 } else { 1.0 };
        let to = [word('X').unwrap_or(at[0]), word('Y').unwrap_or(at[1])];
        let length = (to[0] - at[0]).hypot(to[1] - at[1]);
        let pulled = if length > 0.0 { 0.0 } else { word('E').map_or(0.0, f64::abs) };
        let layer = layers.last_mut().unwrap();
        layer[0] += if length > 0.0 { length } else { pulled } / feed;
        if word('E').is_some() && length > 0.0 {
            layer[1] = f64::max(layer[1], feed);
        }
        at = to;
    }
    layers
}

#[test]
fn a_layer_takes_its_time_or_is_printed_as_slowly_as_may_be() {
    let settings = SliceSettings::default();
    let mut reached = [0, 0];
    for diameter in [3.0, 5.0, 7.0, 9.0, 12.0, 25.0] {
        let mesh = prism(&ring(150.0, 150.0, diameter / 2.0, 64), 0.0, 2.0);
        for [seconds, fastest] in layer_times(&sliced(&mesh, &settings).0) {
            let slowest = fastest <= settings.slowest_mm_per_s + 0.02;
            assert!(slowest || seconds >= settings.min_layer_s - 0.02, "{diameter} mm: {seconds} s at {fastest} mm/s");
            // Nothing is slowed down without need.
            assert!(
                fastest >= 45.0 || seconds <= settings.min_layer_s + 0.05,
                "{diameter} mm: {seconds} s at {fastest} mm/s"
            );
            reached[usize::from(slowest)] += 1;
        }
    }
    assert!(reached.iter().all(|count| *count > 5), "{reached:?}");
    let off = SliceSettings { min_layer_s: 0.0, ..settings };
    let pin = prism(&ring(150.0, 150.0, 1.5, 64), 0.0, 2.0);
    assert!(layer_times(&sliced(&pin, &off).0).iter().all(|[_, fastest]| *fastest > 44.0));
}

#[test]
fn small_and_narrow_pieces_are_full() {
    let settings = SliceSettings::default();
    let full = |mesh: &TriangleMesh<Slot>, volume: f64, s: &SliceSettings| volume_mm3(&sliced(mesh, s).1) / volume;
    for [x, y] in [[0.0, 0.0], [0.31, 0.77], [1.0, 0.3], [0.5, 1.4]] {
        let pin = prism(&ring(150.0 + x, 150.0 + y, 1.5, 64), 0.0, 4.0);
        let volume = 32.0 * 1.5 * 1.5 * (std::f64::consts::TAU / 64.0).sin() * 4.0;
        assert!((0.96..1.02).contains(&full(&pin, volume, &settings)), "{}", full(&pin, volume, &settings));
    }
    // 100 mm2 and more of infill, 1.3 mm wide.
    let wall = block([100.0, 150.0, 0.0], [180.0, 153.0, 4.0]);
    assert!((0.96..1.02).contains(&full(&wall, 960.0, &settings)), "{}", full(&wall, 960.0, &settings));
    let off = SliceSettings { solid_below_mm2: 0.0, solid_below_mm: 0.0, ..settings.clone() };
    assert!(full(&wall, 960.0, &off) < 0.9, "{}", full(&wall, 960.0, &off));
    let wide = block([140.0, 140.0, 0.0], [160.0, 160.0, 8.0]);
    assert!(full(&wide, 3200.0, &settings) < 0.5);
}
