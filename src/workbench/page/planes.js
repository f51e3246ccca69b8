// Planes in the model: what they cut, where one that is moved comes to lie, and how it is turned. Lengths are mm, angles degrees, places those of
// the model's own file.

import { cross, dot, plus } from '/view/renderer.js';

const ARROW_MM = 12; // of a plane, along its normal
const BARB_MM = 4;
const BEYOND_MM = 3; // a plane's frame is so much larger than what it cuts
const FLAT = 1 - 1e-6; // a facet lies along a plane: within 0.1 degrees
const LEVEL_MM = 0.002; // an edge does
const FACE_MM2 = 1; // what is smaller holds no plane
const EDGE_MM = 2;
const MOST_STOPS = 40;
const NEAR = 0.015; // within this share of its way a plane comes to lie on a stop
const STEP_MM = 0.1; // and elsewhere on one of these

/** Where a plane of this direction (a unit vector) lies along a face or an edge of the model, ascending; the largest, where there are many. */
export function stopsOf({ triangles, sharp }, normal) {
  const found = new Map();
  const add = (at, weight) => {
    const key = Math.round(at * 1e4);
    found.set(key, (found.get(key) ?? 0) + weight);
  };
  const corner = (from, i) => [from[i], from[i + 1], from[i + 2]];
  for (const t of triangles) {
    for (let i = 0; i < t.length; i += 18) {
      if (Math.abs(dot(corner(t, i + 3), normal)) < FLAT) continue;
      const a = corner(t, i);
      add(dot(a, normal), Math.hypot(...cross(plus(corner(t, i + 6), a, -1), plus(corner(t, i + 12), a, -1))) / 2 / FACE_MM2);
    }
  }
  for (const ends of sharp) {
    for (let i = 0; i < ends.length; i += 6) {
      const a = corner(ends, i), along = plus(corner(ends, i + 3), a, -1);
      if (Math.abs(dot(along, normal)) < LEVEL_MM) add(dot(a, normal), Math.hypot(...along) / EDGE_MM);
    }
  }
  const kept = [...found].filter(([, weight]) => weight >= 1).sort((a, b) => b[1] - a[1]).slice(0, MOST_STOPS);
  return kept.map(([key]) => key / 1e4).sort((a, b) => a - b);
}

/** Where a plane that somebody moves to `offset` comes to lie: on a stop that is near, as `way` is long, or else on a tenth of a millimetre. */
export function settled(offset, stops, way) {
  const nearest = stops.reduce((best, stop) => (Math.abs(stop - offset) < Math.abs(best - offset) ? stop : best), Infinity);
  return Math.abs(nearest - offset) <= way * NEAR ? nearest : Number((Math.round(offset / STEP_MM) * STEP_MM).toFixed(1)) + 0;
}

/** The stop before (`by` -1) or behind (1) a place; null behind the last one. */
export const stopBeside = (offset, stops, by) => (by < 0 ? stops.findLast((stop) => stop < offset - 1e-4) : stops.find((stop) => stop > offset + 1e-4)) ?? null;

const RADIANS = Math.PI / 180;

/** How far a direction (a unit vector) leans from +Z, and the way it leans, from +X to +Y. */
export function anglesOf([x, y, z]) {
  const around = Math.hypot(x, y);
  return { lean: Math.atan2(around, z) / RADIANS, towards: around < 1e-9 ? 0 : (Math.atan2(y, x) / RADIANS + 360) % 360 };
}

/** The direction that leans so; along an axis it is that to the digit. */
export function leaning({ lean, towards }) {
  const [a, b] = [lean * RADIANS, towards * RADIANS];
  return [Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a)].map((v) => Number(v.toFixed(6)) + 0);
}

/** What a plane cuts, and a frame around that; its arrow, from the middle to its tip, and the same with barbs: ends of lines. */
export function drawn({ triangles, low, high }, normal, offset) {
  const cut = [], u = Math.abs(normal[2]) < 0.9 ? cross([0, 0, 1], normal) : cross([1, 0, 0], normal), long = Math.hypot(...u), x = u.map((v) => v / long), y = cross(normal, x);
  for (const t of triangles) {
    for (let i = 0; i < t.length; i += 18) {
      const corners = [0, 6, 12].map((at) => [t[i + at], t[i + at + 1], t[i + at + 2]]), above = corners.map((p) => dot(p, normal) - offset);
      const ends = corners.flatMap((p, k) => {
        const q = corners[(k + 1) % 3], [a, b] = [above[k], above[(k + 1) % 3]];
        return a > 0 === b > 0 ? [] : [plus(p, plus(q, p, -1), a / (a - b))];
      });
      if (ends.length === 2) cut.push(...ends);
    }
  }
  const box = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((axis) => ((k >> axis) & 1 ? high : low)[axis])), around = cut.length ? cut : box;
  const range = (axis) => [Math.min(...around.map((p) => dot(p, axis))) - BEYOND_MM, Math.max(...around.map((p) => dot(p, axis))) + BEYOND_MM];
  const [[x0, x1], [y0, y1]] = [range(x), range(y)], at = (a, b, c = 0) => plus(plus(plus([0, 0, 0], x, a), y, b), normal, offset + c);
  const [mx, my] = [(x0 + x1) / 2, (y0 + y1) / 2], arrow = [at(mx, my), at(mx, my, ARROW_MM)], barb = (u, v) => [arrow[1], at(mx + u, my + v, ARROW_MM - BARB_MM)];
  const frame = [at(x0, y0), at(x1, y0), at(x1, y0), at(x1, y1), at(x1, y1), at(x0, y1), at(x0, y1), at(x0, y0)];
  const barbs = [[1, 0], [0, 1], [-1, 0], [0, -1]].flatMap(([u, v]) => barb((u * BARB_MM) / 2, (v * BARB_MM) / 2));
  return { lines: [...cut, ...frame].flat(), arrow, head: [...arrow, ...barbs].flat() };
}
