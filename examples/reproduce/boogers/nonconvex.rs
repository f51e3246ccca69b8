//! Chapter 4: supports on the part by connectivity sets. Table 4.1, figures 4.4 to 4.7.

use trunnion::geom::{Angle, Object};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{Cost, Facets, Objective, SupportVolumeColumn};

use super::super::chart::{Chart, Curve};
use super::super::item::{Item, Kind, Row, figures};
use super::super::scene::{BLUE, frame, painted, sheet, solid, tint};
use super::super::sources::Run;
use super::convex::upright;
use super::shapes::{CUT, by_angles, cut_out, smooth, up};

pub(super) fn items(run: &Run) -> Vec<Item> {
    let mut items = vec![states(), compared(run)];
    items.extend(bunny(run));
    items.push(differences());
    items
}

/// Table 4.1: what a facet adds in each of its three states.
fn states() -> Item {
    let mesh = cut_out(2);
    let facets = Facets::of(&mesh);
    // So steep that fields are 0 or 1 but for vertical facets.
    let [volume, interface] = [Cost::Volume, Cost::Interface].map(|cost| smooth(cost, 0.0, 0.0, 400.0, 400.0));
    let z = up(0.0, 0.0);
    let [volumes, areas] = [&volume, &interface].map(|f| f.by_facet(&facets, &z).unwrap_or_default());
    let middle = |i: usize| facets.each[i].barycentre;
    let faces = |i: usize| facets.each[i].area.z / facets.each[i].area.norm();
    // The slot's ceiling, its floor, and the top of the cube.
    let near = |i: usize, z: f64| (middle(i).z - z).abs() < 1e-9;
    let pick = |wanted: &dyn Fn(usize) -> bool| (0..facets.each.len()).find(|&i| wanted(i));
    let all = [
        ("supported", "n.d < 0, D = 1, U = 0, M = 1, adds", pick(&|i| near(i, 0.5) && faces(i) < -0.9)),
        ("support on part", "n.d > 0, D = 0, U = 1, 0 < M < 1, subtracts", pick(&|i| near(i, -0.5) && faces(i) > 0.9)),
        ("no support", "n.d > 0, D = 0, U = 1, M = 0, nothing", pick(&|i| near(i, 1.5) && faces(i) > 0.9)),
    ];
    let mut item = Item::table("4.1", "States of a facet: n.d, fields D and U, weight M, what it adds to the volume");
    for (name, printed, facet) in all {
        let Some(i) = facet else { continue };
        let m = areas[i] / facets.each[i].area.norm();
        let [d, u] = [volume.smoothing.hangs(faces(i))[0], volume.smoothing.carries(faces(i))[0]].map(f64::round);
        let weight = if (m - 1.0).abs() < 1e-6 {
            "M = 1"
        } else if m.abs() < 1e-6 {
            "M = 0"
        } else if m > 0.0 && m < 1.0 {
            "0 < M < 1"
        } else {
            "M outside"
        };
        let adds = if volumes[i] > 1e-9 {
            "adds"
        } else if volumes[i] < -1e-9 {
            "subtracts"
        } else {
            "nothing"
        };
        let sign = if faces(i) < 0.0 { '<' } else { '>' };
        let ours = format!("n.d {sign} 0, D = {d}, U = {u}, {weight}, {adds}");
        item.rows.push(Row::same(name, printed, ours).because(format!(
            "M = {}, {} mm³",
            figures(m),
            figures(volumes[i])
        )));
    }
    item.note("On the cube with a cut-out as it lies: a facet of the slot's ceiling, one of its floor, one of the cube's top.")
}

/// Figure 4.5: the cube with a cut-out, by both methods, and by columns.
fn compared(run: &Run) -> Item {
    let mesh = cut_out(if run.quick { 4 } else { 8 });
    let facets = Facets::of(&mesh);
    let [naive, sets] = [Cost::Convex, Cost::Volume].map(|cost| smooth(cost, 45.0, 0.0, 20.0, 140.0));
    let columns = SupportVolumeColumn { overhang: Angle::from_deg(45.0), resolution_mm: 0.02 };
    let value = |f: &dyn Objective, alpha: f64| f.value(&facets, &up(alpha, 0.0));
    let fine = if run.quick { 73 } else { 181 };
    let range = [-180.0, 180.0];
    let curves = vec![
        Curve::of("convex method", range, fine, |a| value(&naive, a)),
        Curve::of("connectivity sets", range, fine, |a| value(&sets, a)),
        Curve::of("by columns, true volume", range, fine, |a| value(&columns, a)),
    ];
    let below = frame(vec![solid(&mesh, BLUE, None)], "slot towards +Y");
    let row = |alpha: f64| {
        let row = Row::relative(
            format!("sets at {alpha} deg beside the convex method"),
            value(&naive, alpha),
            value(&sets, alpha),
            0.03,
        );
        row.because("around ±90 degrees nothing stands on the part, and both are the same")
    };
    let less = value(&sets, 0.0) < 0.8 * value(&naive, 0.0);
    Item::figure("4.5", "Cube with a cut-out: support volume by the convex method and by connectivity sets")
        .picture("", sheet("Figure 4.5a", 1, vec![below], Vec::new()))
        .picture("", Chart::new("Figure 4.5b: support volume", ["rotation about x, deg", "mm³"], curves).svg())
        .rows([90.0, -90.0].map(row))
        .row(Row::same("at 0 deg the convex method overestimates", "yes", if less { "yes" } else { "no" }))
        .row(
            Row::relative("sets at 0 deg beside the true volume", value(&columns, 0.0), value(&sets, 0.0), 0.7)
                .because("facets of the floor are weighted by the mean of cosines to all they see, not by what stands on them (chapter 6)"),
        )
        .note(format!("Thresholds, k and w as in the thesis's program for this cube; {CUT}."))
}

/// Figures 4.4 and 4.6 on the bunny.
fn bunny(run: &Run) -> Vec<Item> {
    let captions = [
        ("4.4", "Upward and downward fields on a bunny"),
        ("4.6", "Cost of each facet of a bunny for three weightings"),
    ];
    let mesh = match run.mesh("bunny.off") {
        Ok(mesh) => sized(&upright(&mesh)),
        Err(why) => {
            return captions.map(|(number, caption)| Item::left(Kind::Figure, number, caption, why.clone())).into();
        }
    };
    let instead = "the bunny of 6,966 facets of de Castro (2020), 10 mm long; the thesis decimates its own";
    let [volume, area] = [Cost::Volume, Cost::Interface].map(|cost| smooth(cost, 0.0, 0.0, 10.0, 40.0));
    let along = |facet: usize| mesh.normal(facet).map_or(0.0, |n| n.z);
    let field =
        |of: &dyn Fn(f64) -> f64, words: &str| frame(vec![painted(&mesh, |facet| Some(tint(of(along(facet)))))], words);
    let fields = vec![
        field(&|x| volume.smoothing.carries(x)[0], "U, upward field"),
        field(&|x| volume.smoothing.hangs(x)[0], "D, downward field"),
    ];
    let facets = Facets::of(&mesh);
    let z = up(0.0, 0.0);
    let [volumes, areas] = [&volume, &area].map(|f| f.by_facet(&facets, &z).unwrap_or_default());
    let costs = |a: f64, b: f64, words: &str| {
        let of: Vec<f64> = volumes.iter().zip(&areas).map(|(v, s)| a * v + b * s).collect();
        // Per area, as the eye sees it.
        let per: Vec<f64> = of.iter().zip(&facets.each).map(|(cost, facet)| cost / facet.area.norm()).collect();
        let most = per.iter().fold(0.0_f64, |most, cost| most.max(cost.abs()));
        frame(vec![painted(&mesh, |facet| Some(tint(per[facet] / most)))], words)
    };
    let frames = vec![costs(1.0, 0.0, "a = 1, b = 0"), costs(0.5, 0.5, "a = b = 0.5"), costs(0.0, 1.0, "a = 0, b = 1")];
    let lowered = |of: &[f64]| {
        let sum = |sign: f64| of.iter().map(|cost| (sign * cost).max(0.0)).sum::<f64>();
        100.0 * sum(-1.0) / sum(1.0)
    };
    let negative = |of: &[f64]| of.iter().filter(|cost| **cost < -1e-9).count();
    vec![
        Item::figure("4.4", captions[0].1)
            .stand_in(instead)
            .picture("the bluer, the nearer to 1", sheet("Figure 4.4", 2, fields, Vec::new()))
            .row(Row::absolute(
                "U + D of a vertical facet, thresholds 0",
                1.0,
                volume.smoothing.carries(0.0)[0] + volume.smoothing.hangs(0.0)[0],
                1e-12,
                "",
            )),
        Item::figure("4.6", captions[1].1)
            .stand_in(instead)
            .picture("blue raises the cost, red lowers it", sheet("Figure 4.6", 3, frames, Vec::new()))
            .row(
                Row::absolute("what lowers the cost, % of what raises it, a = 0, b = 1", 0.0, lowered(&areas), 2.0, "points")
                    .because(
                        "\"facets that were red before are now blue\"; equation 4.3 is negative for facets that see more overhangs below than above",
                    ),
            )
            .row(Row::same(
                "facets that lower the cost, a = 1, b = 0",
                "some",
                if negative(&volumes) > 0 { "some" } else { "none" },
            )),
    ]
}

/// A mesh scaled to 10 mm along its longest side.
fn sized(mesh: &TriangleMesh<Object>) -> TriangleMesh<Object> {
    let bounds = mesh.bounds();
    let scale = 10.0 / bounds.size().max();
    TriangleMesh::new(mesh.vertices().iter().map(|p| (p - bounds.centre()) * scale).collect(), mesh.facets().to_vec())
}

/// Figure 4.7: gradients beside forward differences.
fn differences() -> Item {
    let facets = Facets::of(&cut_out(4));
    let f = smooth(Cost::Volume, 45.0, 0.0, 10.0, 140.0);
    let at = [30.0, -30.0];
    let by = by_angles(at[0], at[1]);
    let gradient = f.gradient(&facets, &up(at[0], at[1])).unwrap_or_default();
    let error = |k: usize, h: f64| {
        let mut moved = at;
        moved[k] += h.to_degrees();
        let difference = (f.value(&facets, &up(moved[0], moved[1])) - f.value(&facets, &up(at[0], at[1]))) / h;
        let analytic = gradient.dot(&by[k]);
        ((difference - analytic) / analytic).abs()
    };
    let steps: Vec<f64> = (0..=40).map(|i| 10f64.powf(-10.0 + f64::from(i) / 4.0)).collect();
    let curve = |k: usize, name: &str| Curve::line(name, steps.iter().map(|&h| [h, error(k, h)]).collect());
    let chart =
        Chart::new("Figure 4.7: relative error", ["step, rad", ""], vec![curve(0, "by alpha"), curve(1, "by beta")])
            .logarithmic();
    let least = |k: usize| steps.iter().map(|&h| error(k, h)).fold(f64::INFINITY, f64::min);
    let why =
        "\"up to a step size of 1e-4, the finite differences match\"; the first order of a forward difference is left";
    Item::figure("4.7", "Relative error between gradients and forward differences at [30, -30] degrees")
        .stand_in(CUT)
        .picture("", chart.svg())
        .row(Row::absolute("error by alpha at a step of 1e-4", 0.0, error(0, 1e-4), 2e-3, "").because(why))
        .row(Row::absolute("error by beta at a step of 1e-4", 0.0, error(1, 1e-4), 2e-3, "").because(why))
        .row(
            Row::absolute("least error by alpha", 0.0, least(0), 1e-5, "")
                .because("ours is in double precision: the error grows below 1e-8, not below 1e-4"),
        )
        .row(Row::absolute("least error by beta", 0.0, least(1), 1e-5, "").because("the same"))
}
