// The page: what is shown now (`state`), and the two pictures of it, the quick one and the whole one.

const state = {
  move: 0, share: 1, line: 0, playing: false, speed: 60, table: true, dark: false, travels: false, machine: true, parts: false,
  oneLayer: false, measuring: false, points: [], mode: 'part', pose: 0, place: null, finding: null, frames: 0, frameMs: 0, whole: 0, slow: false, late: 0,
};
const facts = JSON.parse(document.getElementById('facts').textContent);
const camera = new Camera();
const byId = (id) => document.getElementById(id);
let replay = null, beads = null, travels = null, few = null, fewer = null, drawing = null, stuff = null, modes = {}, legend = null;
let busy = false, again = false, resting = 0, rest = null, costs = 1e-3; // costs: milliseconds a bead, as measured

async function begin() {
  setTheme(matchMedia('(prefers-color-scheme: dark)').matches);
  const packed = byId('packed'), sections = await unpack(packed.textContent);
  packed.remove(); // the letters are not needed any more
  const shapes = readShapes(facts.parts, sections);
  if (facts.program) {
    replay = new Replay(readProgram(facts.program, sections.slice(2)), facts.machine);
    beads = new Beads(replay);
    modes = colourModes(replay, facts);
    [state.move, state.share] = [replay.count - 1, 1];
  } else {
    state.parts = true;
  }
  panels();
  keys();
  try {
    drawing = new Drawing(byId('canvas'));
    upload(shapes);
  } catch (error) {
    return problem(error.message);
  }
  pointer(byId('canvas'));
  window.addEventListener('message', hearBeside);
  recolour();
  fit();
  seen();
  new ResizeObserver(() => invalidate()).observe(byId('canvas'));
}

function problem(text) {
  byId('problem').textContent = text;
  byId('problem').hidden = false;
}

/** Everything that does not change goes to the graphics memory once. */
function upload(shapes) {
  const whole = (points, faces) => {
    const { triangles, edges } = solid(points, faces);
    return { triangles: drawing.buffer(triangles), count: triangles.length / 6, edges: drawing.buffer(edges), edgeCount: edges.length / 3 };
  };
  const { machine } = facts, hull = (h) => whole(h.points, h.faces), grid = tableGrid(machine.table), box = boxLines(...machine.limits);
  stuff = {
    table: hull(machine.table), grid: drawing.buffer(grid), gridCount: grid.length / 3, box: drawing.buffer(box),
    head: machine.head.map((piece) => ({ ...piece, ...hull(piece.hull) })), frame: machine.frame.map((piece) => ({ ...piece, ...hull(piece.hull) })),
    parts: shapes.map(({ points, faces }, k) => ({ ...whole(points, faces), points, support: facts.parts[k].role === 'support' })),
  };
  if (!replay) return;
  travels = beads.travels();
  [few, fewer] = FEW.map((most) => beads.few(most));
  stuff.beads = drawing.beadSet(beads.points, beads.sizes, beads.colours, 1);
  [stuff.few, stuff.fewer] = [few, fewer].map((set) => drawing.beadSet(set.points, set.sizes, new Uint8Array(set.of.length * 4), 2));
  stuff.now = drawing.beadSet(new Float32Array(6), new Uint16Array(2), new Uint8Array(4), 2);
  stuff.travels = drawing.buffer(travels.points);
}

/** Colours by the mode that is chosen. */
function recolour() {
  if (!replay) return showLegend(partsLegend());
  legend = paint(modes[state.mode], replay, beads.colours);
  showLegend(legend);
  if (!drawing) return;
  drawing.table('colours', beads.colours, stuff.beads.colours);
  [[few, stuff.few], [fewer, stuff.fewer]].forEach(([set, drawn]) => {
    const colours = new Uint8Array(set.of.length * 4);
    set.of.forEach((of, i) => colours.set(beads.colours.subarray(of * 4, of * 4 + 4), i * 4));
    drawing.table('colours', colours, drawn.colours);
  });
  invalidate();
}

/** What is where now: the tip, the table's motion, and the ways from table and machine to the world that is looked at. */
function now() {
  const pose = facts.poses[state.pose];
  const frame = replay ? replay.frame(state.move, state.share)
    : { tip: pose?.tip ?? [null, null, null], motion: pose ? ofMotion(pose.motion) : tableAt(facts.machine, 0, 0), known: true };
  const back = inverted(frame.motion);
  const [fromTable, fromMachine] = state.table ? [IDENTITY, back] : [frame.motion, IDENTITY];
  return { ...frame, back, fromTable, fromMachine };
}

/** The ways to the eye; `table` and `machine` are for what stands in those frames. */
function eyes(at) {
  const { view, projection } = camera.matrices(drawing.canvas.width / drawing.canvas.height);
  const of = (motion) => ({ toEye: times(view, motion), toClip: projection });
  return { table: of(at.fromTable), machine: of(at.fromMachine), of: (motion) => of(times(at.fromMachine, motion)) };
}

const INK = {
  light: { back: [0.953, 0.957, 0.965], table: [196, 202, 210], grid: [120, 130, 142], head: [70, 84, 100], frame: [120, 110, 130], edge: [40, 50, 60], axis: [11, 99, 181], travel: [90, 60, 160], bad: [179, 38, 30], ghost: [176, 182, 190] },
  dark: { back: [0.078, 0.094, 0.114], table: [70, 80, 92], grid: [120, 132, 146], head: [150, 165, 182], frame: [140, 130, 155], edge: [200, 212, 224], axis: [108, 180, 255], travel: [190, 160, 255], bad: [255, 138, 128], ghost: [150, 160, 172] },
};
const ink = () => (state.dark ? INK.dark : INK.light);

/** The two places of the least clearance, table frame, while its line is shown. */
const nearest = () => (replay && currentLine() === facts.verify?.clearance_line ? facts.verify.clearance_at : null);

/** The first bead that is shown, and the first that is not. */
function shownBeads() {
  if (!replay) return [0, 0];
  const done = state.share >= 1 ? state.move + 1 : state.move;
  const layer = replay.layers[replay.layerOf(state.move)] ?? 0;
  return [state.oneLayer ? Math.min(layer, done) : 0, done];
}

function drawBefore(eye) {
  const colours = ink();
  drawing.begin(colours.back);
  drawing.solids(stuff.table.triangles, stuff.table.count, colours.table, 1, eye.table);
  drawing.lines(stuff.grid, stuff.gridCount, colours.grid, 0.45, eye.table);
  drawing.lines(stuff.table.edges, stuff.table.edgeCount, colours.edge, 0.35, eye.table);
}

/** The line under way, as far as it is laid. */
function drawCurrent(at, eye) {
  const i = state.move;
  if (!replay || state.share >= 1 || !(replay.flags[i] & FLAG.lays) || at.tip.includes(null)) return;
  drawing.table('points', new Float32Array([...beads.points.subarray(i * 3, i * 3 + 3), ...moved(at.back, at.tip)]), stuff.now.points);
  drawing.table('sizes', beads.sizes.subarray(i * 2, i * 2 + 2), stuff.now.sizes);
  drawing.table('colours', beads.colours.subarray(i * 4, i * 4 + 4), stuff.now.colours);
  drawing.beads(stuff.now, 0, 1, beads.ups, eye.table);
}

function drawAfter(at, eye, most = Infinity) {
  const colours = ink();
  if (state.parts) drawParts(eye);
  if (state.travels && replay) {
    const last = above(travels.of, state.move), first = Math.max(0, last - most);
    drawing.lines(stuff.travels, (last - first) * 2, colours.travel, 0.75, eye.table, 2e-6, first * 2);
  }
  const near = nearest();
  if (near) drawing.loose([...near.head_mm, ...near.other_mm], colours.bad, 1, eye.table, 0.02);
  if (state.points.length === 2) drawing.loose(state.points.flat(), colours.axis, 1, eye.table, 0.01);
  if (!state.machine) return;
  axes(facts.machine, at).forEach((axis) => drawing.loose(axis.ends.flat(), colours.axis, 0.9, eye.machine));
  if (!facts.machine.swivel) drawing.lines(stuff.box, 24, colours.grid, 0.25, eye.machine);
  const piece = (one, motion, colour, alpha) => {
    drawing.solids(one.triangles, one.count, colour, alpha, eye.of(motion));
    drawing.lines(one.edges, one.edgeCount, colours.edge, alpha, eye.of(motion));
  };
  stuff.frame.forEach((one) => piece(one, IDENTITY, colours.frame, 0.3));
  if (!at.tip.includes(null)) stuff.head.forEach((one) => piece(one, headMotion(one, at), colours.head, 0.32));
}

/** Where a piece of the head is, machine frame. */
function headMotion(one, { tip, tilt, rotation }) {
  const held = (v) => v.map((value, k) => (one.follows[k] ? value : 0));
  if (!one.stays) return shifted(held(tip));
  const seen = unturned(facts.machine, tilt ?? 0, rotation ?? 0), at = linearAxes(facts.machine, seen, tip);
  return times(shifted(tip), times(seen, shifted(at.map((value, k) => (one.follows[k] ? 0 : -value)))));
}

/** The parts' surfaces: over a program as ghosts; of a plan what is printed here, what was before, and what is in the way. */
function drawParts(eye) {
  const colours = ink(), pose = facts.poses[state.pose], against = facts.kind === 'reasons';
  const fresh = (k) => !replay && pose?.fresh.includes(k), struck = (k) => !replay && pose?.struck === k;
  const kinds = stuff.parts
    .map((part, k) => ({ part, clear: (replay || against) && !fresh(k), struck: struck(k), fresh: fresh(k) }))
    .filter((one, k) => replay || !pose || one.fresh || pose.before.includes(k));
  // What is seen through comes last.
  kinds.sort((a, b) => a.clear - b.clear).forEach(({ part, clear, struck, fresh }) => {
    const colour = part.support ? KINDS[1] : fresh ? KINDS[5] : struck ? KINDS[3] : colours.ghost;
    drawing.solids(part.triangles, part.count, colour, !clear ? 1 : struck ? 0.4 : 0.22, eye.table);
    drawing.lines(part.edges, part.edgeCount, colours.edge, clear ? 0.35 : 0.5, eye.table);
  });
}

/** The quick picture, then the whole one when nothing has changed for a while. */
function invalidate() {
  if (!drawing) return;
  tellBeside();
  rest = null;
  clearTimeout(resting);
  again = true;
  if (!busy) requestAnimationFrame(quick);
  busy = true;
}

async function quick() {
  again = false;
  const began = performance.now();
  drawing.resize();
  drawing.aim(false);
  const at = now(), eye = eyes(at), [first, last] = shownBeads();
  drawBefore(eye);
  const all = (last - first) * costs < 40;
  if (replay && all) {
    drawing.beads(stuff.beads, first, last, beads.ups, eye.table);
  } else if (replay) {
    const recent = Math.max(first, last - (state.slow ? 400 : 1500)), { of } = state.slow ? fewer : few;
    drawing.beads(state.slow ? stuff.fewer : stuff.few, above(of, first - 1), above(of, recent - 1), beads.ups, eye.table);
    drawing.beads(stuff.beads, recent, last, beads.ups, eye.table);
  }
  drawCurrent(at, eye);
  drawAfter(at, eye, all ? Infinity : 1500);
  labels(at);
  await drawing.drawn();
  state.frames += 1;
  state.frameMs = performance.now() - began;
  // Too slow for ten a second twice: fewer beads from now on; many times faster: more again.
  state.late = state.frameMs > 90 ? state.late + 1 : 0;
  if (state.late > 1 || (state.slow && state.frameMs < 12)) [state.slow, state.late] = [state.late > 1, 0];
  if (again) return requestAnimationFrame(quick);
  busy = false;
  resting = setTimeout(() => grow((rest = { next: shownBeads()[0], ms: 0, piece: 12000 })), 140);
}

/** The whole picture, a piece at a time; given up as soon as anything changes. */
async function grow(own) {
  const at = now(), eye = eyes(at), [first, last] = shownBeads();
  do {
    const began = performance.now(), until = Math.min(last, own.next + own.piece);
    drawing.aim(true);
    if (own.next === first) drawBefore(eye);
    if (replay) drawing.beads(stuff.beads, own.next, until, beads.ups, eye.table);
    await drawing.drawn();
    if (rest !== own) return;
    const took = performance.now() - began;
    own.ms += took;
    own.next = until;
    // A piece keeps the page waiting: larger ones only where they are quick.
    if (took < 40) own.piece = Math.min(PIECE, own.piece * 2);
  } while (own.next < last);
  // Four samples a point cost about three times as much as one.
  if (last - first > 2000) costs = own.ms / (last - first) / 3;
  drawing.aim(true);
  drawCurrent(at, eye);
  drawAfter(at, eye);
  drawing.show();
  await drawing.drawn();
  state.whole += 1;
}

/** All in sight. */
function fit() {
  const box = beads ? beads.box : boxOf(stuff ? stuff.parts.flatMap(({ points }) => [...points]) : []);
  const middle = box.low.map((v, k) => (v + box.high[k]) / 2), half = box.high.map((v, k) => (v - box.low[k]) / 2);
  const aspect = byId('canvas').clientWidth / byId('canvas').clientHeight;
  camera.fit(moved(now().fromTable, middle), Math.max(20, Math.hypot(...half)) * (state.machine ? 1.15 : 1), aspect);
  invalidate();
}

function boxOf(points) {
  const box = { low: [-40, -40, 0], high: [40, 40, 40] };
  if (points.length) for (let k = 0; k < 3; k++) [box.low[k], box.high[k]] = [Infinity, -Infinity];
  points.forEach((v, i) => {
    box.low[i % 3] = Math.min(box.low[i % 3], v);
    box.high[i % 3] = Math.max(box.high[i % 3], v);
  });
  return box;
}

/** Goes to a move; `line` where a line without a move of its own is meant. */
function seek(move, share = 1, line = 0) {
  state.move = Math.min(Math.max(0, move), replay.count - 1);
  [state.share, state.line, state.place] = [share, line, null];
  seen();
}

/** To line `number`: its move done, or all before it. */
function seekLine(number) {
  const line = Math.min(Math.max(1, Math.round(number)), replay.facts.lines);
  seek(replay.moveOfLine(line), 1, line);
}

/** The whole state is shown anew. */
function seen() {
  follow();
  invalidate();
}

let lastTick = 0;
function play(on) {
  state.playing = on && !!replay;
  byId('play').textContent = state.playing ? 'Pause' : 'Play';
  if (!state.playing) return seen();
  if (state.move === replay.count - 1 && state.share >= 1) seek(0, 0);
  lastTick = performance.now();
  requestAnimationFrame(tick);
}

function tick(at) {
  if (!state.playing) return;
  const time = replay.timeOf(state.move, state.share) + (Math.min(250, Math.max(0, at - lastTick)) / 1000) * state.speed;
  lastTick = at;
  if (time >= replay.seconds) {
    seek(replay.count - 1);
    return play(false);
  }
  const { move, share } = replay.whenAt(time);
  seek(move, share);
  requestAnimationFrame(tick);
}

const ready = begin().catch((error) => problem(`this page cannot be shown: ${error.message}`));

/** For programs that drive the page: where it is, and what it holds. */
window.trunnion = {
  ready, state, facts, camera, seek: (move, share) => seek(move, share), seekLine, fit, text: (line) => replay.text(line), invalidate: () => invalidate(), canvas: () => byId('canvas'),
  frame: () => { const { tip, tilt, rotation, motion } = now(); return { tip, tilt, rotation, motion, line: currentLine() }; },
  get replay() { return replay; }, get beads() { return beads; }, get few() { return few; },
};
