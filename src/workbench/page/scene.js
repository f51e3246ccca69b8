// The models on the machine's table, drawn by the preview's own renderer.

import { Camera, Drawing, IDENTITY, axes, cross, dot, inverted, moved, plus, readShapes, solid, tableAt, tableGrid, turned } from '/view/renderer.js';
import { drawn, stopsOf } from './planes.js';
import { block } from './server.js';

const INK = {
  light: { back: [0.937, 0.945, 0.957], table: [226, 230, 236], grid: [120, 130, 142], edge: [40, 50, 60], axis: [11, 99, 181], part: [150, 174, 200], hangs: [236, 140, 0], line: [30, 40, 52], chosen: [11, 99, 181], found: [90, 100, 112], bad: [200, 30, 30] },
  dark: { back: [0.063, 0.078, 0.098], table: [58, 67, 78], grid: [110, 122, 136], edge: [190, 202, 214], axis: [108, 180, 255], part: [128, 154, 182], hangs: [230, 140, 20], line: [12, 16, 22], chosen: [108, 180, 255], found: [176, 186, 198], bad: [255, 110, 110] },
};
const GAP_MM = 12; // between models in the picture
const CELL_MM = 5;
const TOUCHES_MM = 0.1; // parts that are nearer touch
const GRIP_PX = 12; // a plane's arrow is taken so near to it
const FLATTEST_PX = 0.2; // an arrow that is seen from its end, a millimetre of it shorter than this, is not moved
const STANDS_MM = 0.05; // as near to the lowest point a facet lies on the table

export class Scene {
  /**
   * `picked` hears of a face that was clicked: the direction out of it, how far along that it is, and which part of which model it is of. `slid` hears of a plane whose arrow is dragged:
   * its number, how far along its direction it would be, and whether it was let go.
   */
  constructor(canvas, picked, slid) {
    Object.assign(this, { canvas, picked, slid, picking: null, planes: [], lines: [], drawing: new Drawing(canvas), camera: new Camera(), machine: null, steepest: 45, models: new Map(), order: [], asked: 0 });
    this.dark = matchMedia('(prefers-color-scheme: dark)');
    this.dark.addEventListener('change', () => this.invalidate());
    new ResizeObserver(() => this.invalidate()).observe(canvas);
    this.pointer();
  }

  /** The machine, as the server draws it; null without one. */
  setMachine(drawn) {
    this.machine = drawn?.machine ? this.prepared(drawn.machine) : null;
    this.steepest = drawn?.steepest_deg ?? 45;
    this.models.clear();
    this.invalidate();
  }

  prepared(machine) {
    const { points, faces } = machine.table, made = solid(points, faces), grid = tableGrid(machine.table);
    return {
      facts: machine, reach: points.reduce((most, v, i) => (i % 3 < 2 ? Math.max(most, Math.abs(v)) : most), 0),
      table: this.drawing.buffer(made.triangles), count: made.triangles.length / 6, edges: this.drawing.buffer(made.edges), edgeCount: made.edges.length / 3,
      grid: this.drawing.buffer(grid), gridCount: grid.length / 3,
    };
  }

  /**
   * Fetches what is new of `models` (a key each, which changes with the file), as the project was at `revision`, and draws them with `up` up.
   * False where the project has changed meanwhile: then nothing is drawn, so that no key gets what another model is, and it is to be asked anew.
   */
  async setModels(models, revision, up) {
    const turn = (this.asked += 1);
    for (const [index, { key }] of models.entries()) {
      if (this.models.has(key)) continue;
      const [got, failed] = await block(index, revision).then((got) => [got, null], (failed) => [null, failed]);
      if (turn !== this.asked || failed?.code === 'workbench/old-revision') return turn !== this.asked;
      this.models.set(key, got && this.built(got, up)); // where there is none, the list says why
    }
    this.order = models.map(({ key }) => this.models.get(key)).filter(Boolean);
    this.place();
    this.fit();
    return true;
  }

  /** Triangles of one model: those that a layer below holds, and those that are steeper than the machine's rule. */
  built({ parts, columns }, up) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity], made = [];
    const turn = upright(up);
    for (const { points, faces } of readShapes(parts, columns)) {
      for (let i = 0; i < points.length; i += 3) points.set(turned(turn, [points[i], points[i + 1], points[i + 2]]), i);
      for (let i = 0; i < points.length; i++) [low[i % 3], high[i % 3]] = [Math.min(low[i % 3], points[i]), Math.max(high[i % 3], points[i])];
      made.push(solid(points, faces));
    }
    const limit = -Math.sin((this.steepest * Math.PI) / 180) - 1e-6, held = [], hanging = [], carried = made.length > 1 ? floors(made) : () => false;
    for (const [part, { triangles }] of made.entries()) {
      for (let i = 0; i < triangles.length; i += 18) {
        const stands = Math.max(triangles[i + 2], triangles[i + 8], triangles[i + 14]) < low[2] + STANDS_MM;
        (triangles[i + 5] < limit && !stands && !carried(part, triangles, i) ? hanging : held).push(triangles.subarray(i, i + 18));
      }
    }
    const joined = (list) => {
      const all = new Float32Array(list.length * 18);
      list.forEach((triangle, i) => all.set(triangle, i * 18));
      return { buffer: this.drawing.buffer(all), count: list.length * 3 };
    };
    const outline = rimOf(hanging), rim = this.drawing.buffer(outline), rimCount = outline.length / 3;
    const edges = made.map(({ edges: one }) => ({ buffer: this.drawing.buffer(one), count: one.length / 3 }));
    return { low, high, turn, triangles: made.map(({ triangles }) => triangles), sharp: made.map(({ edges: one }) => one), stops: new Map(), rim, rimCount, held: joined(held), hanging: joined(hanging), edges, shift: [0, 0, 0] };
  }

  /** Side by side on the middle of the table, for the picture. */
  place() {
    const wide = this.order.reduce((sum, { low, high }) => sum + high[0] - low[0], GAP_MM * Math.max(0, this.order.length - 1));
    let at = -wide / 2;
    for (const model of this.order) {
      const { low, high } = model;
      model.shift = [at - low[0], -(low[1] + high[1]) / 2, -low[2]];
      at += high[0] - low[0] + GAP_MM;
    }
    this.wide = wide;
  }

  fit() {
    const high = Math.max(20, ...this.order.map(({ low, high: top }) => top[2] - low[2]));
    const own = Math.max(30, this.wide ?? 0, high, ...this.order.map(({ low, high: top }) => top[1] - low[1]));
    const radius = this.order.length ? own * 0.85 : (this.machine?.reach ?? 120) * 0.95;
    this.camera.fit([0, 0, this.order.length ? high / 2 : 0], radius, this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight));
    this.invalidate();
  }

  get hangs() {
    return this.order.some((model) => model.hanging.count > 0);
  }

  invalidate() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  draw() {
    const { drawing, machine } = this, ink = this.dark.matches ? INK.dark : INK.light;
    if (!this.canvas.clientWidth) return;
    drawing.resize();
    drawing.aim(true);
    drawing.begin(ink.back);
    const { view, projection } = this.camera.matrices(this.canvas.width / this.canvas.height);
    const eye = { toEye: view, toClip: projection };
    if (machine) {
      drawing.solids(machine.table, machine.count, ink.table, 1, eye);
      drawing.lines(machine.grid, machine.gridCount, ink.grid, 0.35, eye);
      drawing.lines(machine.edges, machine.edgeCount, ink.edge, 0.3, eye);
      this.axes(eye, ink);
    }
    for (const model of this.order) {
      const own = { toEye: shiftedBy(view, model.shift), toClip: projection };
      drawing.solids(model.held.buffer, model.held.count, ink.part, 1, own);
      drawing.solids(model.hanging.buffer, model.hanging.count, ink.hangs, 1, own);
      model.edges.forEach(({ buffer, count }) => drawing.lines(buffer, count, ink.line, 0.55, own));
      // Seen through the part: what is steep looks down.
      drawing.lines(model.rim, model.rimCount, ink.hangs, 1, own, 0.03);
    }
    for (const { points, head, kind, shift } of this.lines) {
      const own = { toEye: shiftedBy(view, shift), toClip: projection };
      drawing.loose(points, ink[kind], 1, own);
      // Seen through the part: what is dragged has to be found.
      drawing.loose(head, ink[kind], 1, own, 0.1);
    }
    drawing.show();
    this.frames = (this.frames ?? 0) + 1;
  }

  /** Tilt and rotation axis, in the table's frame at rest. */
  axes(eye, ink) {
    const { facts } = this.machine, rest = tableAt(facts, 0, 0), back = [0, 1, 2].map((k) => rest[12 + k]);
    axes(facts, { motion: rest, tip: [0, 0, 0], tilt: 0, rotation: 0, known: true }).slice(3).forEach(({ ends }) => this.drawing.loose(ends.map((end) => plus(end, back, -1)).flat(), ink.axis, 0.8, eye));
  }

  /** What the next click chooses a face for; null for nothing. */
  pick(what) {
    this.picking = what;
    this.canvas.classList.toggle('picking', what !== null);
  }

  /** One part of a model, to be cut; null where it is not drawn. */
  partAt({ model, part }) {
    const { triangles, sharp, ...one } = this.order[model] ?? {};
    return triangles?.[part] ? { ...one, triangles: [triangles[part]], sharp: [sharp[part]] } : null;
  }

  /** Planes of models as they were drawn: normal, where along it, kind, and of which part of which model. */
  setPlanes(planes) {
    const wanted = JSON.stringify(planes), models = this.order;
    if (this.planes === wanted && this.planed === models) return;
    [this.planes, this.planed] = [wanted, models];
    const one = ({ normal, offset, kind, k, ...place }) => {
      const part = this.partAt(place);
      if (!part) return [];
      const { lines, arrow, head } = drawn(part, normal, offset);
      return [{ points: lines, kind, k, normal, offset, arrow, head, shift: part.shift }];
    };
    this.lines = planes.flatMap(one);
    this.invalidate();
  }

  /** Where planes of this direction lie along a face or an edge of a part. */
  stops(normal, place) {
    const model = this.order[place.model], key = [place.part, ...normal].join(), part = this.partAt(place);
    if (!part) return [];
    if (!model.stops.has(key)) model.stops.set(key, stopsOf(part, normal));
    return model.stops.get(key);
  }

  /** The middle of what a plane cuts of a part. */
  middleOf(normal, offset, place) {
    const part = this.partAt(place);
    return part && drawn(part, normal, offset).arrow[0];
  }

  /** Where a place of a model that is shifted so is in the picture, in its pixels. */
  seenAt(place, shift) {
    const { clientWidth: width, clientHeight: height } = this.canvas, { view } = this.camera.matrices(width / height);
    const [x, y, depth] = moved(view, plus(place, shift)), per = height / 2 / Math.tan(this.camera.fov / 2) / -depth;
    return [width / 2 + x * per, height / 2 - y * per];
  }

  /** The plane of somebody's whose arrow is near a place of the picture; undefined beside them. */
  gripped(x, y) {
    return this.lines.find(({ kind, arrow, shift }) => {
      if (kind === 'found' || this.picking) return false;
      const [[ax, ay], [bx, by]] = arrow.map((end) => this.seenAt(end, shift)), [ux, uy] = [bx - ax, by - ay], long = ux * ux + uy * uy;
      const t = Math.min(1, Math.max(0, ((x - ax) * ux + (y - ay) * uy) / (long || 1)));
      return Math.hypot(x - ax - t * ux, y - ay - t * uy) <= GRIP_PX;
    });
  }

  /** How far along its direction a gripped plane is where the pointer has gone from `from` to `to`. */
  draggedTo(plane, from, to) {
    const [begin, end] = [from, to].map((at) => this.alongArrow(plane, at));
    return begin === null || end === null ? plane.offset : plane.offset + end - begin;
  }

  /** How far from its middle a plane's arrow, however long, is nearest to a place of the picture; null where it is seen from its end. */
  alongArrow({ normal, arrow: [middle], shift }, [x, y]) {
    const seen = (by) => this.seenAt(plus(middle, normal, by), shift);
    let by = 0;
    // What is farther away is seen smaller: each step corrects the one before.
    for (let step = 0; step < 6; step++) {
      const [a, b] = [seen(by), seen(by + 1)], [ux, uy] = plus(b, a, -1), long = ux * ux + uy * uy;
      if (long < FLATTEST_PX ** 2) return null;
      by += ((x - a[0]) * ux + (y - a[1]) * uy) / long;
    }
    return by;
  }

  /** The face under a place of the picture: the direction of the model out of it, how far along that it is, and of which part; null beside the models. */
  faceAt(x, y) {
    const { camera, canvas } = this, { eye } = camera.matrices(1), half = Math.tan(camera.fov / 2), { clientWidth: width, clientHeight: height } = canvas;
    const u = ((x / width) * 2 - 1) * half * (width / height), v = (1 - (y / height) * 2) * half;
    const ray = plus(plus(plus([0, 0, 0], camera.back, -1), camera.right, u), cross(camera.back, camera.right), v);
    let best = { at: Infinity, face: null };
    for (const [model, { shift, turn, triangles }] of this.order.entries()) {
      const from = plus(eye, shift, -1);
      for (const [part, t] of triangles.entries()) {
        for (let i = 0; i < t.length; i += 18) {
          const at = hit(t, i, from, ray);
          if (at < best.at) best = { at, model, part, face: [[t[i + 3], t[i + 4], t[i + 5]], [t[i], t[i + 1], t[i + 2]]].map((v) => turned(inverted(turn), v)) };
        }
      }
    }
    if (!best.face) return null;
    const { model, part, face: [normal, corner] } = best;
    return { model, part, normal: normal.map((value) => Number(value.toFixed(6)) + 0), offset: Number(dot(normal, corner).toFixed(4)) + 0 };
  }

  orbit(yaw, pitch) {
    this.camera.yaw += yaw;
    this.camera.pitch = Math.min(1.5707, Math.max(-1.5707, this.camera.pitch + pitch));
    this.invalidate();
  }

  pan(dx, dy) {
    const { camera } = this, mm = (camera.distance * 2 * Math.tan(camera.fov / 2)) / this.canvas.clientHeight, up = cross(camera.back, camera.right);
    camera.target = plus(plus(camera.target, camera.right, -dx * mm), up, dy * mm);
    this.invalidate();
  }

  zoom(by) {
    this.camera.distance = Math.min(20000, Math.max(1, this.camera.distance * by));
    this.invalidate();
  }

  pointer() {
    const { canvas } = this, down = new Map();
    let travelled = 0, grip = null;
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      const at = [event.offsetX, event.offsetY], plane = down.size === 0 && event.button === 0 && this.gripped(...at);
      grip = plane ? { plane, at } : null;
      down.set(event.pointerId, at);
      travelled = 0;
    });
    canvas.addEventListener('pointermove', (event) => {
      const last = down.get(event.pointerId), at = [event.offsetX, event.offsetY];
      if (!last) {
        canvas.classList.toggle('grip', Boolean(this.gripped(...at)));
        return;
      }
      if (grip) {
        this.slid(grip.plane.k, this.draggedTo(grip.plane, grip.at, at), false);
        return;
      }
      const [dx, dy] = [event.offsetX - last[0], event.offsetY - last[1]];
      down.set(event.pointerId, at);
      travelled += Math.abs(dx) + Math.abs(dy);
      if (down.size === 2 || event.shiftKey || event.buttons & 2) this.pan(dx, dy);
      else this.orbit(-dx * 0.008, dy * 0.008);
    });
    canvas.addEventListener('pointerup', (event) => {
      if (grip) this.slid(grip.plane.k, this.draggedTo(grip.plane, grip.at, [event.offsetX, event.offsetY]), true);
      const face = this.picking && travelled < 4 && this.faceAt(event.offsetX, event.offsetY);
      if (face) this.picked(face);
    });
    canvas.addEventListener('pointercancel', () => { if (grip) this.slid(grip.plane.k, grip.plane.offset, true); });
    ['pointerup', 'pointercancel'].forEach((name) => canvas.addEventListener(name, (event) => { grip = null; down.delete(event.pointerId); }));
    canvas.addEventListener('wheel', (event) => { event.preventDefault(); this.zoom(Math.exp(Math.sign(event.deltaY) * 0.12)); }, { passive: false });
    const keys = {
      ArrowLeft: () => this.orbit(-0.1, 0), ArrowRight: () => this.orbit(0.1, 0), ArrowUp: () => this.orbit(0, 0.1), ArrowDown: () => this.orbit(0, -0.1),
      '+': () => this.zoom(0.85), '-': () => this.zoom(1.18), f: () => this.fit(),
    };
    canvas.addEventListener('keydown', (event) => {
      if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation();
      keys[event.key]();
    });
  }
}

/** The least rotation that brings a direction (three numbers with commas) upright; none for a word. */
function upright(text) {
  const [x, y, z] = text.split(',').map(Number), long = Math.hypot(x, y, z), [a, b, c] = [x / long, y / long, z / long];
  if (!Number.isFinite(c) || c > 1 - 1e-9) return IDENTITY;
  if (c < -1 + 1e-9) return [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1];
  const k = 1 / (1 + c);
  return [1 - k * a * a, -k * a * b, a, 0, -k * a * b, 1 - k * b * b, b, 0, -a, -b, c, 0, 0, 0, 0, 1];
}

/** How far along a ray a triangle is met; infinite where it is not. */
function hit(t, i, from, ray) {
  const at = (k) => [t[i + k], t[i + k + 1], t[i + k + 2]], a = at(0), p = plus(at(6), a, -1), q = plus(at(12), a, -1);
  const n = cross(ray, q), det = dot(p, n);
  if (Math.abs(det) < 1e-12) return Infinity;
  const s = plus(from, a, -1), u = dot(s, n) / det, m = cross(s, p), v = dot(ray, m) / det, far = dot(q, m) / det;
  return u < 0 || v < 0 || u + v > 1 || far <= 0 ? Infinity : far;
}

/** Whether a triangle that looks down lies on another part, which carries it: by its middle, among what looks up there. */
function floors(made) {
  const cells = new Map(), at = (v) => Math.floor(v / CELL_MM);
  made.forEach(({ triangles: t }, part) => {
    for (let i = 0; i < t.length; i += 18) {
      if (t[i + 5] < 0.01) continue;
      const [xs, ys] = [0, 1].map((k) => [t[i + k], t[i + 6 + k], t[i + 12 + k]]);
      for (let x = at(Math.min(...xs)); x <= at(Math.max(...xs)); x++) {
        for (let y = at(Math.min(...ys)); y <= at(Math.max(...ys)); y++) {
          const key = `${x} ${y}`;
          if (!cells.has(key)) cells.set(key, []);
          cells.get(key).push([part, t, i]);
        }
      }
    }
  });
  return (part, t, i) => {
    const [x, y, z] = [0, 1, 2].map((k) => (t[i + k] + t[i + 6 + k] + t[i + 12 + k]) / 3);
    return (cells.get(`${at(x)} ${at(y)}`) ?? []).some(([other, u, j]) => other !== part && Math.abs(heightAt(u, j, x, y) - z) < TOUCHES_MM);
  };
}

/** The height of a triangle above a point of the plane; not a number beside it. */
function heightAt(t, i, x, y) {
  const side = (a, b) => (t[i + b] - t[i + a]) * (y - t[i + a + 1]) - (t[i + b + 1] - t[i + a + 1]) * (x - t[i + a]);
  if (Math.min(side(0, 6), side(6, 12), side(12, 0)) < -1e-6) return NaN;
  return t[i + 2] - (t[i + 3] * (x - t[i]) + t[i + 4] * (y - t[i + 1])) / t[i + 5];
}

/** The lines around patches of triangles: edges that one triangle alone has. */
function rimOf(triangles) {
  const edges = new Map(), key = (p) => p.map((v) => Math.round(v * 1000)).join();
  for (const one of triangles) {
    const corners = [0, 6, 12].map((at) => [one[at], one[at + 1], one[at + 2]]);
    corners.forEach((p, k) => {
      const q = corners[(k + 1) % 3], name = [key(p), key(q)].sort().join(' ');
      edges.set(name, edges.has(name) ? null : [...p, ...q]);
    });
  }
  return new Float32Array([...edges.values()].filter(Boolean).flat());
}

/** The matrix of a view, after a shift. */
function shiftedBy(m, [x, y, z]) {
  const out = [...(m ?? IDENTITY)];
  for (let row = 0; row < 4; row++) out[12 + row] += m[row] * x + m[row + 4] * y + m[row + 8] * z;
  return out;
}
