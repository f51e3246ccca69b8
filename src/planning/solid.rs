//! Solids for collision: one convex hull where a part is convex, else its facets in a tree of boxes.

use std::collections::HashMap;

use super::fans::Fans;
use crate::geom::convex::{Separation, separation_by, support};
use crate::geom::{Bounds, Mat3, Rigid, Vec3};
use crate::mesh::TriangleMesh;

/// The shape of a part (or the table) at a pose, machine coordinates.
#[derive(Clone, Debug)]
pub struct Solid {
    points: Vec<Vec3>,
    pieces: Pieces,
    /// The box around it.
    pub bounds: Bounds,
}

#[derive(Clone, Debug)]
enum Pieces {
    /// The hull of all points is the solid.
    Convex,
    /// Its surface.
    Facets { facets: Vec<[u32; 3]>, tree: Vec<FacetBox> },
}

/// A node of the tree: `count` facets from `first`, and its two children from `children`; a leaf has one facet and none.
#[derive(Clone, Copy, Debug)]
struct FacetBox {
    bounds: Bounds,
    first: u32,
    count: u32,
    children: u32,
}

impl FacetBox {
    fn is_leaf(&self) -> bool {
        self.count <= 1
    }
}

/// Up to so many facets, or points of a convex solid, a node is asked as the hull of its points. Its box is quicker, but wide where
/// facets are long and lie across the axes, as those of a slanting rod do.
const AS_HULL: usize = 48;
/// Beyond so many points the hull of all of them is no quick question any more.
const WHOLE: usize = 20_000;

impl Solid {
    /// The solid inside a closed mesh.
    pub fn of<F>(mesh: &TriangleMesh<F>) -> Self {
        let points = mesh.vertices().to_vec();
        let bounds = mesh.bounds();
        if is_convex(mesh) {
            return Self { points, pieces: Pieces::Convex, bounds };
        }
        let mut facets = mesh.facets().to_vec();
        let tree = tree(&points, &mut facets);
        Self { points, pieces: Pieces::Facets { facets, tree }, bounds }
    }

    /// The hull of `points`.
    pub fn hull(points: Vec<Vec3>) -> Self {
        let bounds = Bounds::of(points.iter().copied());
        Self { points, pieces: Pieces::Convex, bounds }
    }

    /// The same solid after a rotation and a shift; a tree is built anew.
    pub fn moved(&self, rotation: &Mat3, shift: &Vec3) -> Self {
        let points: Vec<Vec3> = self.points.iter().map(|p| rotation * p + shift).collect();
        let bounds = Bounds::of(points.iter().copied());
        let pieces = match &self.pieces {
            Pieces::Convex => Pieces::Convex,
            Pieces::Facets { facets, .. } => {
                let mut facets = facets.clone();
                let tree = tree(&points, &mut facets);
                Pieces::Facets { facets, tree }
            }
        };
        Self { points, pieces, bounds }
    }

    /// Whether it is the hull of its points.
    pub fn is_hull(&self) -> bool {
        matches!(self.pieces, Pieces::Convex)
    }

    /// Its corner points.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// The box of the places of its corners where `motion` takes them: of the tip, while it is printed.
    pub(super) fn reached<A, B>(&self, motion: &Rigid<A, B>) -> Bounds {
        Bounds::of(self.points.iter().map(|p| motion.rotation * p + motion.translation))
    }

    /// How far the convex `tool`, its origin swept over `self` with `swept` zeroed where the tool does not follow, stays
    /// from `obstacle`, up to `enough` mm; [`Separation::Meeting`] where it meets it. `motion` takes both solids to the
    /// tool's frame: they stay where they are, so that one tree of a part serves every pose.
    ///
    /// Exact for the surfaces to 1e-6 relative. Containment needs no test of its own as long as the tool reaches upward
    /// without end: see [`Head`](super::Head).
    pub fn swept_clearance<A, B>(
        &self,
        motion: &Rigid<A, B>,
        follows: [bool; 3],
        tool: &[Vec3],
        obstacle: &Self,
        enough: f64,
    ) -> Separation {
        self.tool_clearance(motion, follows, &Tool::Points(tool), obstacle, enough)
    }

    /// The same for any tool.
    pub(super) fn tool_clearance<A, B>(
        &self,
        motion: &Rigid<A, B>,
        follows: [bool; 3],
        tool: &Tool<'_>,
        obstacle: &Self,
        enough: f64,
    ) -> Separation {
        self.query(motion, follows, tool, obstacle).clearance(enough, false)
    }

    /// Whether the same stays at least `mm` away.
    pub(super) fn tool_clears<A, B>(
        &self,
        motion: &Rigid<A, B>,
        follows: [bool; 3],
        tool: &Tool<'_>,
        obstacle: &Self,
        mm: f64,
    ) -> bool {
        let mut query = self.query(motion, follows, tool, obstacle);
        // What is printed is mostly as good as convex, and what stands lies below it: then one question is enough.
        query.hull_clears(mm) || query.clearance(mm, true).distance() >= mm
    }

    fn query<'a, A, B>(
        &'a self,
        motion: &Rigid<A, B>,
        follows: [bool; 3],
        tool: &'a Tool<'a>,
        obstacle: &'a Self,
    ) -> Query<'a> {
        Query {
            swept: self,
            mask: Vec3::from_fn(|i, _| if follows[i] { 1.0 } else { 0.0 }),
            tool,
            tool_box: tool.bounds(),
            obstacle,
            turn: motion.rotation,
            back: motion.rotation.transpose(),
            spread: motion.rotation.abs(),
            shift: motion.translation,
            axis: Vec3::z(),
        }
    }
}

/// What is swept.
pub(super) enum Tool<'a> {
    /// The hull of some points.
    Points(&'a [Vec3]),
    /// A piece of the head, raised by some mm, and wider by some on every side, seen from above.
    Fans { fans: &'a Fans, raise: f64, wider: f64 },
}

impl Tool<'_> {
    fn bounds(&self) -> Bounds {
        match *self {
            Self::Points(points) => Bounds::of(points.iter().copied()),
            Self::Fans { fans, raise, wider } => {
                let (lift, around) = (Vec3::z() * raise, Vec3::new(wider, wider, 0.0));
                Bounds { min: fans.bounds.min + lift - around, max: fans.bounds.max + lift + around }
            }
        }
    }

    /// The point farthest along `d`, the disc about each point included.
    fn farthest(&self, d: &Vec3) -> Vec3 {
        match *self {
            Self::Points(points) => support(points, d),
            Self::Fans { fans, raise, wider } => {
                let mut point = fans.farthest(d);
                point.z += raise;
                let across = (d.x * d.x + d.y * d.y).sqrt();
                if wider == 0.0 || across < 1e-12 {
                    return point;
                }
                point + Vec3::new(d.x, d.y, 0.0) * (wider / across)
            }
        }
    }
}

struct Query<'a> {
    swept: &'a Solid,
    mask: Vec3,
    tool: &'a Tool<'a>,
    tool_box: Bounds,
    obstacle: &'a Solid,
    turn: Mat3,
    back: Mat3,
    spread: Mat3,
    shift: Vec3,
    /// The direction along which the last two sets were told apart: mostly it does for the next two.
    axis: Vec3,
}

impl Query<'_> {
    /// Whether the tool that sweeps the hull of all that it should sweep stays `mm` away: no, where that is not proved.
    fn hull_clears(&mut self, mm: f64) -> bool {
        if self.swept.is_hull() || self.swept.points.len() > WHOLE {
            return false;
        }
        let mut stack = vec![0usize];
        while let Some(b) = stack.pop() {
            let (swept, obstacle) = (Reach::Points(&self.swept.points), self.obstacle.reach(b));
            if self.apart(&swept, &obstacle, mm).distance() >= mm {
                continue;
            }
            if self.obstacle.node(b).1 {
                return false;
            }
            stack.extend(self.obstacle.children(b));
        }
        true
    }

    /// The least distance below `enough`; `any` that is below it will do where only that is asked.
    fn clearance(&mut self, enough: f64, any: bool) -> Separation {
        let mut least = enough;
        let mut stack = vec![(0usize, 0usize)];
        while let Some((a, b)) = stack.pop() {
            let (box_a, leaf_a) = self.swept.node(a);
            let (box_b, leaf_b) = self.obstacle.node(b);
            if self.gap(&box_a, &box_b) >= least {
                continue;
            }
            // The boxes around boxes are wide where the tool is slender: before a pair is opened, it is asked exactly.
            let apart = self.apart(&self.swept.reach(a), &self.obstacle.reach(b), least);
            if apart.distance() >= least {
                continue;
            }
            match (leaf_a, leaf_b) {
                (true, true) => match apart {
                    Separation::Apart(mm) if !any => least = mm,
                    found => return found,
                },
                (true, false) => stack.extend(self.obstacle.children(b).map(|b| (a, b))),
                (false, true) => stack.extend(self.swept.children(a).map(|a| (a, b))),
                (false, false) => {
                    if box_a.size().norm() > box_b.size().norm() {
                        stack.extend(self.swept.children(a).map(|a| (a, b)));
                    } else {
                        stack.extend(self.obstacle.children(b).map(|b| (a, b)));
                    }
                }
            }
        }
        Separation::Apart(least)
    }

    /// A lower bound of the distance between what the tool sweeps over box `a` and box `b`, along the tool's axes: the
    /// head is slender there, and would fill any other box.
    fn gap(&self, a: &Bounds, b: &Bounds) -> f64 {
        let (a, b) = (self.turned(a), self.turned(b));
        let min = a.min.component_mul(&self.mask) + self.tool_box.min;
        let max = a.max.component_mul(&self.mask) + self.tool_box.max;
        let apart = |i: usize| (b.min[i] - max[i]).max(min[i] - b.max[i]).max(0.0);
        Vec3::new(apart(0), apart(1), apart(2)).norm()
    }

    /// The separation of what the tool sweeps over `a` from `b`, where it is below `enough`.
    fn apart(&mut self, a: &Reach<'_>, b: &Reach<'_>, enough: f64) -> Separation {
        let (turn, back, shift, mask, tool) = (self.turn, self.back, self.shift, self.mask, self.tool);
        let of_swept = |d: &Vec3| {
            let far = turn * a.farthest(&(back * d.component_mul(&mask))) + shift;
            far.component_mul(&mask)
        };
        let reach = |d: &Vec3| of_swept(d) + tool.farthest(d) - (turn * b.farthest(&(back * -d)) + shift);
        separation_by(reach, enough, &mut self.axis)
    }

    /// The box around a turned box.
    fn turned(&self, b: &Bounds) -> Bounds {
        let (centre, half) = (self.turn * b.centre() + self.shift, self.spread * (b.size() * 0.5));
        Bounds { min: centre - half, max: centre + half }
    }
}

/// What a node may hold, as its farthest points: the hull of what it has, or something around that.
enum Reach<'a> {
    Box(Bounds),
    Points(&'a [Vec3]),
    Facets(&'a [Vec3], &'a [[u32; 3]]),
}

impl Reach<'_> {
    fn farthest(&self, d: &Vec3) -> Vec3 {
        match *self {
            Self::Box(Bounds { min, max }) => Vec3::from_fn(|i, _| if d[i] > 0.0 { max[i] } else { min[i] }),
            Self::Points(points) => support(points, d),
            Self::Facets(points, facets) => {
                let corners = facets.iter().flatten().map(|&i| points[i as usize]);
                corners.max_by(|p, q| p.dot(d).total_cmp(&q.dot(d))).unwrap_or_default()
            }
        }
    }
}

impl Solid {
    fn node(&self, index: usize) -> (Bounds, bool) {
        match &self.pieces {
            Pieces::Convex => (self.bounds, true),
            Pieces::Facets { tree, .. } => (tree[index].bounds, tree[index].is_leaf()),
        }
    }

    fn children(&self, index: usize) -> [usize; 2] {
        match &self.pieces {
            Pieces::Convex => [0, 0],
            Pieces::Facets { tree, .. } => {
                let first = tree[index].children as usize;
                [first, first + 1]
            }
        }
    }

    /// Exact for a leaf.
    fn reach(&self, index: usize) -> Reach<'_> {
        match &self.pieces {
            Pieces::Convex => Reach::Points(&self.points),
            Pieces::Facets { facets, tree } => {
                let FacetBox { bounds, first, count, .. } = tree[index];
                let facets = &facets[first as usize..(first + count) as usize];
                if facets.len() <= AS_HULL { Reach::Facets(&self.points, facets) } else { Reach::Box(bounds) }
            }
        }
    }
}

/// The tree over `facets`, which it sorts: halves by the middles along the longest axis of each box.
fn tree(points: &[Vec3], facets: &mut [[u32; 3]]) -> Vec<FacetBox> {
    let corners = |facet: &[u32; 3]| facet.map(|i| points[i as usize]);
    let boxes: Vec<Bounds> = facets.iter().map(|facet| Bounds::of(corners(facet))).collect();
    let middles: Vec<Vec3> = facets.iter().map(|facet| corners(facet).iter().sum()).collect();
    let mut order: Vec<u32> = (0..facets.len() as u32).collect();
    let mut tree = Vec::with_capacity(2 * facets.len());
    tree.push(FacetBox { bounds: Bounds::EMPTY, first: 0, count: 0, children: 0 });
    let of = Halved { facets, boxes: &boxes, middles: &middles };
    of.build(&mut order, 0, &mut tree, 0);
    let sorted: Vec<[u32; 3]> = order.iter().map(|&facet| facets[facet as usize]).collect();
    facets.copy_from_slice(&sorted);
    tree
}

/// What a tree is built of; `middles` are thrice the middles of the facets.
struct Halved<'a> {
    facets: &'a [[u32; 3]],
    boxes: &'a [Bounds],
    middles: &'a [Vec3],
}

impl Halved<'_> {
    /// The node `at`, of the facets in `order`, of which the first comes at `offset`.
    fn build(&self, order: &mut [u32], offset: usize, tree: &mut Vec<FacetBox>, at: usize) {
        let bounds = order.iter().fold(Bounds::EMPTY, |all, &facet| all.union(&self.boxes[facet as usize]));
        tree[at] = FacetBox { bounds, first: offset as u32, count: order.len() as u32, children: tree.len() as u32 };
        if tree[at].is_leaf() {
            return;
        }
        let axis = bounds.size().imax();
        let middle = order.len() / 2;
        let key = |facet: u32| self.middles[facet as usize][axis];
        let same = |a: u32, b: u32| self.facets[a as usize].cmp(&self.facets[b as usize]);
        order.select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)).then_with(|| same(a, b)));
        let first = tree.len();
        tree.extend([tree[at]; 2]);
        let (low, high) = order.split_at_mut(middle);
        self.build(low, offset, tree, first);
        self.build(high, offset + middle, tree, first + 1);
    }
}

/// So many facets are asked first whether all lies behind them, and so many times the tolerance is more than many edges make together.
const FEW_FACETS: usize = 16;
const DENTED: f64 = 100.0;

/// Convex where no edge bends inward; a closed, connected, locally convex surface is convex.
///
/// The tolerance is a ten-thousandth of the part's size: the hull then departs from the surface by less than a layer's
/// hundredth, and always outward, which is the safe side.
fn is_convex<F>(mesh: &TriangleMesh<F>) -> bool {
    let tolerance = mesh.bounds().size().norm() * 1e-4;
    // Most are not by far: some vertex lies beyond one of a few facets.
    let dented = |index: usize| {
        let (a, normal) = (mesh.corners(index)[0], mesh.normal(index));
        normal.is_some_and(|normal| mesh.vertices().iter().any(|p| (p - a).dot(&normal) > DENTED * tolerance))
    };
    if (0..mesh.facets().len()).step_by(mesh.facets().len() / FEW_FACETS + 1).any(dented) {
        return false;
    }
    let mut across: HashMap<(u32, u32), usize> = HashMap::with_capacity(mesh.facets().len() * 3);
    for (index, facet) in mesh.facets().iter().enumerate() {
        for i in 0..3 {
            across.insert((facet[i], facet[(i + 1) % 3]), index);
        }
    }
    let bends_out = |index: usize| {
        let facet = mesh.facets()[index];
        let Some(normal) = mesh.normal(index) else { return true };
        let a = mesh.vertices()[facet[0] as usize];
        (0..3).all(|i| {
            let Some(&other) = across.get(&(facet[(i + 1) % 3], facet[i])) else { return false };
            mesh.corners(other).iter().all(|p| (p - a).dot(&normal) <= tolerance)
        })
    };
    let whole = mesh.facets().first().is_some_and(|_| connected(mesh, &across));
    whole && (0..mesh.facets().len()).all(bends_out)
}

/// Whether the surface is one piece: a cavity is locally convex seen from its own side.
fn connected<F>(mesh: &TriangleMesh<F>, across: &HashMap<(u32, u32), usize>) -> bool {
    let mut seen = vec![false; mesh.facets().len()];
    let mut stack = vec![0];
    let mut count = 0;
    while let Some(index) = stack.pop() {
        if std::mem::replace(&mut seen[index], true) {
            continue;
        }
        count += 1;
        let f = mesh.facets()[index];
        stack.extend((0..3).filter_map(|i| across.get(&(f[(i + 1) % 3], f[i])).copied()).filter(|&o| !seen[o]));
    }
    count == mesh.facets().len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{SplitMix64, Table};

    /// An L of 30 x 30 x 10 mm with arms 10 wide, as a closed mesh.
    fn ell() -> TriangleMesh<Table> {
        let outline = [(0.0, 0.0), (30.0, 0.0), (30.0, 10.0), (10.0, 10.0), (10.0, 30.0), (0.0, 30.0)];
        let mut vertices: Vec<Vec3> = outline.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect();
        vertices.extend(outline.iter().map(|&(x, y)| Vec3::new(x, y, 10.0)));
        let mut facets = vec![];
        for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
            facets.push([a, c, b]);
            facets.push([a + 6, b + 6, c + 6]);
        }
        for i in 0..6u32 {
            let j = (i + 1) % 6;
            facets.push([i, j, j + 6]);
            facets.push([i, j + 6, i + 6]);
        }
        TriangleMesh::new(vertices, facets)
    }

    fn still() -> Rigid<Table, Table> {
        Rigid::shift(Vec3::zeros())
    }

    fn cube_at(centre: Vec3, half: f64) -> Solid {
        let body = crate::geom::Body::cuboid("", centre.add_scalar(-half), centre.add_scalar(half), [true; 3]);
        Solid::hull(body.points)
    }

    #[test]
    fn an_ell_is_not_convex_and_its_notch_is_free() {
        let solid = Solid::of(&ell());
        assert!(matches!(solid.pieces, Pieces::Facets { .. }));
        let tool = [Vec3::zeros()];
        let in_notch = cube_at(Vec3::new(20.0, 20.0, 5.0), 5.0);
        let got = solid.swept_clearance(&still(), [true; 3], &tool, &in_notch, f64::INFINITY).distance();
        assert!((got - 5.0).abs() < 1e-4, "{got}");
        let in_arm = cube_at(Vec3::new(5.0, 29.0, 5.0), 2.0);
        assert_eq!(solid.swept_clearance(&still(), [true; 3], &tool, &in_arm, 1.0), Separation::Meeting);
    }

    #[test]
    fn a_tool_that_does_not_follow_y_keeps_its_own() {
        let swept = cube_at(Vec3::new(0.0, 50.0, 0.0), 1.0);
        let beam = crate::geom::Body::cuboid("", Vec3::new(-1.0, -5.0, 10.0), Vec3::new(1.0, 5.0, 12.0), [true; 3]);
        let post = cube_at(Vec3::new(0.0, 0.0, 11.0), 1.0);
        assert_eq!(swept.swept_clearance(&still(), [true, false, true], &beam.points, &post, 1.0), Separation::Meeting);
        let got = swept.swept_clearance(&still(), [true; 3], &beam.points, &post, f64::INFINITY).distance();
        assert!((got - 43.0).abs() < 1e-4, "{got}");
    }

    /// The head of the shipped machine, some shapes with many facets that are not convex, and any motion.
    #[test]
    fn whether_it_clears_is_what_all_pairs_of_facets_say() {
        let mut random = SplitMix64::seeded(11);
        let cone = crate::geom::Body::frustum("", [0.0, 12.0], [0.5, 7.0], [true; 3]);
        let fans = Fans::of(&cone.points, 500.0);
        let fine = |turn: Mat3, shift: Vec3| {
            // Each facet of the L in sixteen, so that nodes of all sizes are met.
            let mesh = (0..2).fold(ell(), |mesh, _| quartered(&mesh));
            Solid::of(&mesh).moved(&turn, &shift)
        };
        let turned = |random: &mut SplitMix64| {
            let axis = nalgebra::Unit::new_normalize(random.direction());
            *nalgebra::Rotation3::from_axis_angle(&axis, random.unit() * 3.0).matrix()
        };
        let (mut clear, mut not) = (0, 0);
        for case in 0..30 {
            let swept = fine(turned(&mut random), Vec3::new(0.0, 0.0, 40.0 * random.unit()));
            let apart = Vec3::new(60.0 * random.unit() - 10.0, 20.0 * random.unit(), -45.0 * random.unit());
            let obstacle = fine(turned(&mut random), apart);
            let motion: Rigid<Table, Table> = Rigid::new(turned(&mut random), random.direction() * 5.0);
            let follows = [true, case % 5 != 0, true];
            let raise = random.unit();
            let tool = Tool::Fans { fans: &fans, raise, wider: if case % 3 == 0 { 0.2 } else { 0.0 } };
            let wanted = by_all_pairs(&swept, &motion, follows, &tool, &obstacle);
            let got = swept.tool_clearance(&motion, follows, &tool, &obstacle, f64::INFINITY).distance();
            assert!((got - wanted).abs() <= 2e-6 * (1.0 + wanted), "{case}: {got} for {wanted}");
            for mm in
                [1e-3, 0.5 * wanted, 0.999 * wanted, 1.001 * wanted, wanted + 1.0].into_iter().filter(|mm| *mm > 0.0)
            {
                let clears = swept.tool_clears(&motion, follows, &tool, &obstacle, mm);
                assert_eq!(clears, wanted >= mm, "{case}: {mm} of {wanted}");
                if clears { clear += 1 } else { not += 1 }
            }
        }
        assert!(clear > 20 && not > 20, "{clear} clear, {not} not: says little");
    }

    fn quartered(mesh: &TriangleMesh<Table>) -> TriangleMesh<Table> {
        let (mut vertices, mut facets) = (Vec::new(), Vec::new());
        for facet in 0..mesh.facets().len() {
            let [a, b, c] = mesh.corners(facet);
            let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
            for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                facets.push([0, 1, 2].map(|i| (vertices.len() + i) as u32));
                vertices.extend(corners);
            }
        }
        TriangleMesh::new(vertices, facets)
    }

    /// The least distance of all pairs of facets, none left out.
    fn by_all_pairs(
        swept: &Solid,
        motion: &Rigid<Table, Table>,
        follows: [bool; 3],
        tool: &Tool<'_>,
        obstacle: &Solid,
    ) -> f64 {
        let mask = Vec3::from_fn(|i, _| if follows[i] { 1.0 } else { 0.0 });
        let corners = |solid: &Solid, facet: &[u32; 3]| {
            facet.map(|i| motion.rotation * solid.points[i as usize] + motion.translation)
        };
        let facets = |solid: &Solid| match &solid.pieces {
            Pieces::Facets { facets, .. } => facets.clone(),
            Pieces::Convex => panic!("not convex"),
        };
        let mut least = f64::INFINITY;
        for a in facets(swept) {
            let a = corners(swept, &a).map(|p| p.component_mul(&mask));
            for b in facets(obstacle) {
                let b = corners(obstacle, &b);
                let reach = |d: &Vec3| support(&a, d) + tool.farthest(d) - support(&b, &-d);
                least = least.min(crate::geom::convex::separation(reach, f64::INFINITY).distance());
            }
        }
        least
    }
}
