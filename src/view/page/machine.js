// Table, head, frame and parts as triangles with flat normals, and the lines along their edges.

const EDGE = Math.cos(0.45); // neighbours that turn by more than this (radians) have an edge between them

/** Corners and faces to triangles (place and normal of each corner) and edges (pairs of places). */
function solid(points, faces) {
  const corner = (i) => [points[i * 3], points[i * 3 + 1], points[i * 3 + 2]];
  const triangles = new Float32Array(faces.length * 6), edges = new Map();
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => corner(faces[f + k]));
    const up = normal(cross(plus(b, a, -1), plus(c, a, -1)));
    [a, b, c].forEach((p, k) => triangles.set([...p, ...up], (f + k) * 6));
    for (let k = 0; k < 3; k++) {
      const [p, q] = [faces[f + k], faces[f + ((k + 1) % 3)]], key = p < q ? p * 4294967296 + q : q * 4294967296 + p;
      if (edges.has(key)) edges.get(key).ups.push(up);
      else edges.set(key, { ends: [p, q], ups: [up] });
    }
  }
  const sharp = [...edges.values()].filter(({ ups }) => ups.length < 2 || dot(ups[0], ups[1]) < EDGE);
  return { triangles, edges: new Float32Array(sharp.flatMap(({ ends: [p, q] }) => [...corner(p), ...corner(q)])) };
}

/** Lines 10 mm apart on the table, cut at its rim. */
function tableGrid(hull) {
  const top = [];
  for (let i = 0; i < hull.points.length; i += 3) if (Math.abs(hull.points[i + 2]) < 1e-6) top.push([hull.points[i], hull.points[i + 1]]);
  top.sort((a, b) => Math.atan2(a[1], a[0]) - Math.atan2(b[1], b[0]));
  const lines = [];
  const reach = Math.max(10, ...top.map(([x, y]) => Math.max(Math.abs(x), Math.abs(y))));
  for (let axis = 0; axis < 2; axis++) {
    for (let at = -Math.floor(reach / 10) * 10; at <= reach; at += 10) {
      const ends = [];
      top.forEach((p, i) => {
        const q = top[(i + 1) % top.length];
        if (p[axis] > at !== q[axis] > at) ends.push(p[1 - axis] + ((at - p[axis]) / (q[axis] - p[axis])) * (q[1 - axis] - p[1 - axis]));
      });
      if (ends.length === 2) ends.forEach((end) => lines.push(...(axis ? [end, at] : [at, end]), 0.02));
    }
  }
  return new Float32Array(lines);
}

/** The lines of a box. */
function boxLines(low, high) {
  const at = (i) => [0, 1, 2].map((k) => ((i >> k) & 1 ? high[k] : low[k]));
  const lines = [];
  for (let i = 0; i < 8; i++) for (const k of [1, 2, 4]) if (!(i & k)) lines.push(...at(i), ...at(i | k));
  return new Float32Array(lines);
}

/** Of tilt and rotation axis those that the machine has. */
function own({ tilt, rotation }, ...ends) {
  return [tilt, rotation].map((axis, i) => ({ ends: ends[i], label: axis.letter, absent: axis.absent })).filter(({ absent }) => !absent);
}

/** The axes of a head that turns: through its joints, which hang from the tip. */
function headAxes(machine, { motion, tip, tilt, rotation }) {
  const { yaws, tilt_from_tip: u, rotation_from_tip: v } = machine.swivel;
  const lean = turnAround(machine.tilt.along, tilt, u), joint = plus(tip, u);
  const [middle, up] = yaws
    ? [plus(tip, moved(lean, [v[0], v[1], u[2] + 30])), turned(lean, machine.rotation.along)]
    : [moved(motion, [0, 0, 0]), turned(motion, machine.rotation.along)];
  const reach = machine.table.points.reduce((most, v) => Math.max(most, Math.abs(v)), 0), origin = moved(motion, [-reach - 35, 0, 0]);
  const inRoom = (axis) => turned(unturned(machine, tilt, rotation), axis);
  const triad = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis, i) => ({ ends: [origin, plus(origin, inRoom(axis), 25)], label: 'XYZ'[i] }));
  const ends = (at, along, long) => [plus(at, along, -long), plus(at, along, long)];
  return [...triad, ...own(machine, ends(joint, machine.tilt.along, 40), ends(middle, up, 30))];
}

/** Where the axes are: X, Y and Z at the pivot, the tilt axis through it, the rotation axis through the table's middle. */
function axes(machine, at) {
  if (machine.swivel) return at.known && !at.tip.includes(null) ? headAxes(machine, { tilt: 0, rotation: 0, ...at }) : [];
  const { motion } = at;
  const { pivot } = machine, reach = machine.table.points.reduce((most, v) => Math.max(most, Math.abs(v)), 0), long = reach + 35;
  const { along } = machine.tilt, middle = moved(motion, [0, 0, 0]), up = turned(motion, machine.rotation.along);
  const tiltEnds = [plus(pivot, along, -long), plus(pivot, along, long)];
  const turnEnds = [plus(middle, up, -50), plus(middle, up, 25)];
  const origin = plus(machine.pivot, along, -long);
  const triad = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis, i) => ({ ends: [origin, plus(origin, axis, 25)], label: 'XYZ'[i] }));
  return [...triad, ...own(machine, tiltEnds, turnEnds)];
}
