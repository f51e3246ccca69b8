//! What is sliced and judged: shapes made of corners and numbers alone, in the slot frame on a bed of 200 mm. Millimetres.

use std::f64::consts::TAU;

use trunnion::geom::{Slot, Vec3};
use trunnion::mesh::TriangleMesh;

/// A named solid; its surface may consist of several closed ones that overlap or lie in each other.
pub(crate) struct Named {
    pub(crate) name: String,
    pub(crate) mesh: TriangleMesh<Slot>,
}

const MIDDLE: f64 = 100.0;

/// Corners and facets under construction.
#[derive(Default)]
struct Solid {
    vertices: Vec<Vec3>,
    facets: Vec<[u32; 3]>,
}

impl Solid {
    /// The closed surface through rings of equally many corners, lowest first, counter-clockwise from above; each end is fanned about
    /// its middle.
    fn skin(&mut self, rings: &[Vec<Vec3>]) {
        let (base, n) = (self.vertices.len() as u32, rings[0].len() as u32);
        self.vertices.extend(rings.iter().flatten());
        for level in 0..rings.len() as u32 - 1 {
            let low = base + level * n;
            for i in 0..n {
                let j = (i + 1) % n;
                self.facets.extend([[low + i, low + j, low + n + j], [low + i, low + n + j, low + n + i]]);
            }
        }
        let top = base + (rings.len() as u32 - 1) * n;
        for (first, up) in [(base, false), (top, true)] {
            let middle = self.vertices.len() as u32;
            let ring = &self.vertices[first as usize..(first + n) as usize];
            self.vertices.push(ring.iter().sum::<Vec3>() / f64::from(n));
            for i in 0..n {
                let (a, b) = (first + i, first + (i + 1) % n);
                self.facets.push(if up { [a, b, middle] } else { [b, a, middle] });
            }
        }
    }

    fn prism(&mut self, ring: &[[f64; 2]], low: f64, high: f64) {
        self.skin(&[at_height(ring, low), at_height(ring, high)]);
    }

    fn block(&mut self, low: [f64; 3], high: [f64; 3]) {
        let ring = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
        self.prism(&ring, low[2], high[2]);
    }

    /// A hollow in the shape of the facets from `first` on.
    fn turn_inside_out(&mut self, first: usize) {
        self.facets[first..].iter_mut().for_each(|facet| facet.swap(1, 2));
    }

    fn named(self, name: impl Into<String>) -> Named {
        let shift = Vec3::new(MIDDLE, MIDDLE, 0.0);
        let vertices = self.vertices.into_iter().map(|v| v + shift).collect();
        Named { name: name.into(), mesh: TriangleMesh::new(vertices, self.facets) }
    }
}

fn at_height(ring: &[[f64; 2]], z: f64) -> Vec<Vec3> {
    ring.iter().map(|p| Vec3::new(p[0], p[1], z)).collect()
}

/// A ring of `count` corners whose distance from the middle is `radius(share of the turn)`.
fn round(count: usize, radius: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let at = |k: usize| k as f64 / count as f64;
    (0..count).map(|k| ((TAU * at(k)).sin_cos(), radius(at(k)))).map(|((s, c), r)| [r * c, r * s]).collect()
}

fn moved(ring: &[[f64; 2]], by: [f64; 2]) -> Vec<[f64; 2]> {
    ring.iter().map(|p| [p[0] + by[0], p[1] + by[1]]).collect()
}

/// A body of revolution through `(radius, z)`.
fn turned(profile: &[[f64; 2]], sides: usize) -> Vec<Vec<Vec3>> {
    profile.iter().map(|[r, z]| at_height(&round(sides, |_| *r), *z)).collect()
}

fn ball(radius: f64, low: f64, solid: &mut Solid) {
    let at = |k: usize| TAU / 2.0 * (k as f64 + 0.25) / 48.5;
    let profile: Vec<[f64; 2]> = (0..49).map(|k| [radius * at(k).sin(), low + radius - radius * at(k).cos()]).collect();
    // The lowest ring stands at z = `low`, as a mesh on its bed does.
    let down = profile[0][1] - low;
    solid.skin(&turned(&profile.iter().map(|[r, z]| [*r, z - down]).collect::<Vec<_>>(), 96));
}

fn simple() -> Vec<Named> {
    let mut all = Vec::new();
    let mut add = |name: &str, build: &dyn Fn(&mut Solid)| {
        let mut solid = Solid::default();
        build(&mut solid);
        all.push(solid.named(name));
    };
    add("cube", &|s| s.block([-10.0, -10.0, 0.0], [10.0, 10.0, 4.0]));
    add("cylinder", &|s| s.prism(&round(128, |_| 9.0), 0.0, 4.0));
    add("cone", &|s| s.skin(&turned(&[[9.0, 0.0], [0.6, 9.0]], 96)));
    add("sphere", &|s| ball(7.0, 0.0, s));
    add("torus", &|s| {
        // Two surfaces: the outer one, and the hole's turned inside out.
        let profile = |sign: f64| -> Vec<[f64; 2]> {
            (0..=32)
                .map(|k| (TAU / 2.0 * f64::from(k) / 32.0).sin_cos())
                .map(|(s, c)| [8.0 + sign * 3.0 * s, 3.0 - 3.0 * c])
                .collect()
        };
        s.skin(&turned(&profile(1.0), 96));
        let first = s.facets.len();
        s.skin(&turned(&profile(-1.0), 96));
        s.turn_inside_out(first);
    });
    add("gear", &|s| {
        s.prism(&round(192, |t| if ((t * 48.0) as usize).is_multiple_of(2) { 10.0 } else { 8.5 }), 0.0, 3.0)
    });
    add("star", &|s| {
        s.prism(&round(14, |t| if ((t * 14.0).round() as usize).is_multiple_of(2) { 12.0 } else { 4.0 }), 0.0, 3.0)
    });
    add("text", &|s| text(s));
    add("overlapping bodies", &|s| {
        for k in 0..10 {
            let (x, y) = (2.3 * f64::from(k) - 10.0, 3.0 * (f64::from(k) * 1.7).sin());
            if k % 2 == 0 {
                s.block([x - 2.0, y - 3.0, 0.0], [x + 2.0, y + 3.0, 3.0]);
            } else {
                s.prism(&moved(&round(64, |_| 2.8), [x, y]), 0.0, 3.0);
            }
        }
    });
    add("shell", &|s| {
        s.block([-8.0, -8.0, 0.0], [8.0, 8.0, 6.0]);
        let first = s.facets.len();
        s.block([-7.0, -7.0, 1.0], [7.0, 7.0, 5.0]);
        s.turn_inside_out(first);
    });
    add("maze", &|s| {
        for k in 0..5 {
            let (low, high) = (2.5 * f64::from(k), 2.5 * f64::from(k) + 1.0);
            s.block([low - 12.0, -12.0, 0.0], [high - 12.0, 12.0 - low, 3.0]);
            s.block([low - 12.0, 12.0 - low - 1.0, 0.0], [12.0 - low, 12.0 - low, 3.0]);
        }
    });
    add("fins", &|s| {
        s.block([-10.0, -6.0, 0.0], [10.0, -2.0, 3.0]);
        for (k, thick) in [0.35, 0.5, 0.7, 0.9, 1.2, 1.6, 2.2].into_iter().enumerate() {
            let x = -9.0 + 2.7 * k as f64;
            s.block([x, -2.5, 0.0], [x + thick, 8.0, 3.0]);
        }
    });
    all
}

/// `TEHL` in strokes of 1.3 mm that overlap.
fn text(s: &mut Solid) {
    let strokes = [
        [0.0, 8.7, 6.0, 10.0],
        [2.35, 0.0, 3.65, 10.0],
        [8.0, 0.0, 9.3, 10.0],
        [8.0, 0.0, 13.0, 1.3],
        [8.0, 4.4, 12.0, 5.7],
        [8.0, 8.7, 13.0, 10.0],
        [15.0, 0.0, 16.3, 10.0],
        [20.0, 0.0, 21.3, 10.0],
        [15.0, 4.4, 21.3, 5.7],
        [23.0, 0.0, 24.3, 10.0],
        [23.0, 0.0, 28.0, 1.3],
    ];
    for [x0, y0, x1, y1] in strokes {
        s.block([x0 - 14.0, y0 - 5.0, 0.0], [x1 - 14.0, y1 - 5.0, 2.0]);
    }
}

/// A wall of each thickness, 20 mm long.
pub(crate) fn walls(thick: &[f64]) -> Vec<Named> {
    let one = |thick: &f64| {
        let mut solid = Solid::default();
        solid.block([-thick / 2.0, -10.0, 0.0], [thick / 2.0, 10.0, 2.0]);
        solid.named(format!("wall {thick}"))
    };
    thick.iter().map(one).collect()
}

/// Wedges from above, of these angles, 16 mm long; the sharpest more, so that what its tip lacks is not too much of it.
pub(crate) fn wedges(degrees: &[f64]) -> Vec<Named> {
    let one = |deg: &f64| {
        let length = if *deg < 5.0 { 40.0 } else { 16.0 };
        let half = length * (deg / 2.0).to_radians().tan();
        let mut solid = Solid::default();
        solid.prism(&[[-8.0, 0.0], [length - 8.0, -half], [length - 8.0, half]], 0.0, 2.0);
        solid.named(format!("wedge {deg}"))
    };
    degrees.iter().map(one).collect()
}

fn holes() -> Vec<Named> {
    let mut upright = Solid::default();
    upright.block([-12.0, -6.0, 0.0], [12.0, 6.0, 3.0]);
    let first = upright.facets.len();
    for (diameter, x) in [(1.0, -10.0), (2.0, -6.5), (3.0, -2.0), (4.0, 3.0), (5.0, 8.8)] {
        upright.prism(&moved(&round(48, |_| diameter / 2.0), [x, 0.0]), 0.0, 3.0);
    }
    upright.turn_inside_out(first);
    let mut lying = Solid::default();
    lying.block([-12.0, -4.0, 0.0], [12.0, 4.0, 8.0]);
    let first = lying.facets.len();
    for (diameter, x) in [(1.0, -10.0), (2.0, -6.5), (3.0, -2.0), (4.0, 3.0), (5.0, 8.8)] {
        let ring = round(48, |_| diameter / 2.0);
        let side = |y: f64| ring.iter().map(|p| Vec3::new(p[0] + x, y, p[1] + 4.0)).collect::<Vec<_>>();
        lying.skin(&[side(4.0), side(-4.0)]);
    }
    lying.turn_inside_out(first);
    vec![upright.named("holes upright"), lying.named("holes lying")]
}

/// Roofs of these slopes from the horizontal, their ridge 0.5 mm wide.
fn roofs(degrees: &[f64]) -> Vec<Named> {
    let one = |deg: &f64| {
        let rise = 6.0f64.min(7.75 * deg.to_radians().tan());
        let top = 8.0 - rise / deg.to_radians().tan();
        let ring = |x: f64, z: f64| at_height(&[[-x, -6.0], [x, -6.0], [x, 6.0], [-x, 6.0]], z);
        let mut solid = Solid::default();
        solid.skin(&[ring(8.0, 0.0), ring(8.0, 1.0), ring(top, 1.0 + rise)]);
        solid.named(format!("roof {deg}"))
    };
    degrees.iter().map(one).collect()
}

/// Pins of 3 mm at places of no pattern.
pub(crate) fn pins() -> Vec<Named> {
    let one = |k: u32| {
        let at = [f64::from(k) * 0.737 % 1.9, f64::from(k) * 0.413 % 1.7];
        let mut solid = Solid::default();
        solid.prism(&moved(&round(64, |_| 1.5), at), 0.0, 3.0);
        solid.named(format!("pin {k}"))
    };
    (0..10).map(one).collect()
}

/// Decks over air: between two posts, over a hollow, and between posts on a slant; a box with walls of 1.2 mm; many pins.
pub(crate) fn bridging() -> Vec<Named> {
    let mut all = Vec::new();
    let mut add = |name: &str, build: &dyn Fn(&mut Solid)| {
        let mut solid = Solid::default();
        build(&mut solid);
        all.push(solid.named(name));
    };
    add("bridge", &|s| {
        s.block([-12.0, -5.0, 0.0], [-4.0, 5.0, 3.0]);
        s.block([4.0, -5.0, 0.0], [12.0, 5.0, 3.0]);
        s.block([-12.0, -5.0, 3.0], [12.0, 5.0, 5.0]);
    });
    add("pit", &|s| {
        s.block([-10.0, -10.0, 0.0], [10.0, 10.0, 5.0]);
        let first = s.facets.len();
        s.block([-6.0, -3.0, 0.9], [6.0, 3.0, 3.1]);
        s.turn_inside_out(first);
    });
    add("slant notch", &|s| {
        let (sin, cos) = 25f64.to_radians().sin_cos();
        let turned = |ring: &[[f64; 2]]| -> Vec<[f64; 2]> {
            ring.iter().map(|[x, y]| [x * cos - y * sin, x * sin + y * cos]).collect()
        };
        let half = |from: f64, to: f64| turned(&[[from, -6.0], [to, -6.0], [to, 6.0], [from, 6.0]]);
        s.prism(&half(-12.0, -3.0), 0.0, 3.0);
        s.prism(&half(3.0, 12.0), 0.0, 3.0);
        s.prism(&half(-12.0, 12.0), 3.0, 5.0);
    });
    add("thin box", &|s| {
        s.block([-15.0, -15.0, 0.0], [15.0, 15.0, 1.2]);
        s.block([-15.0, -15.0, 0.0], [15.0, -13.8, 6.0]);
        s.block([-15.0, 13.8, 0.0], [15.0, 15.0, 6.0]);
        s.block([-15.0, -15.0, 0.0], [-13.8, 15.0, 6.0]);
        s.block([13.8, -15.0, 0.0], [15.0, 15.0, 6.0]);
    });
    add("pins on a plate", &|s| {
        s.block([-12.0, -12.0, 0.0], [12.0, 12.0, 1.0]);
        for k in 0..36 {
            let at = [f64::from(k % 6) * 4.0 - 10.0, f64::from(k / 6) * 4.0 - 10.0];
            s.prism(&moved(&round(24, |_| 1.0), at), 1.0, 3.0);
        }
    });
    all
}

/// All of them.
pub(crate) fn all() -> Vec<Named> {
    let mut all = simple();
    all.extend(holes());
    all.extend(wedges(&[3.0, 5.0, 10.0, 20.0, 30.0]));
    all.extend(walls(&[0.3, 0.35, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4, 1.6, 2.0, 2.5, 3.0]));
    all.extend(roofs(&[14.0, 30.0, 45.0, 60.0, 75.0]));
    all
}
