// Mouse, pen, fingers and keys: the camera, the measured distance, and a key for everything.

/** From the page's pixels to the picture's, and back: a point of the world on the page; null behind the eye. */
function onPage(point) {
  const canvas = byId('canvas'), { view, projection } = camera.matrices(canvas.clientWidth / canvas.clientHeight);
  const m = times(projection, view), [x, y] = moved(m, point), w = m[3] * point[0] + m[7] * point[1] + m[11] * point[2] + m[15];
  return w > 0 ? [((x / w + 1) / 2) * canvas.clientWidth, ((1 - y / w) / 2) * canvas.clientHeight, w] : null;
}

/** What is under a place of the page, table frame: the nearest of what is laid (or of the parts), else the table's surface. */
function picked(x, y) {
  const at = now(), canvas = byId('canvas'), aspect = canvas.clientWidth / canvas.clientHeight;
  const { view, projection } = camera.matrices(aspect), m = times(times(projection, view), at.fromTable);
  let best = null;
  const look = (p, i) => {
    const w = m[3] * p[i] + m[7] * p[i + 1] + m[11] * p[i + 2] + m[15];
    if (w <= 0) return;
    const px = (((m[0] * p[i] + m[4] * p[i + 1] + m[8] * p[i + 2] + m[12]) / w + 1) / 2) * canvas.clientWidth;
    const py = ((1 - (m[1] * p[i] + m[5] * p[i + 1] + m[9] * p[i + 2] + m[13]) / w) / 2) * canvas.clientHeight;
    const off = Math.hypot(px - x, py - y);
    // Among those that are hit the foremost: a pixel aside counts as a millimetre behind.
    if (off < 12 && (!best || w + off < best.rank)) best = { rank: w + off, point: [p[i], p[i + 1], p[i + 2]] };
  };
  const [first, last] = shownBeads();
  for (let i = first; i < last; i++) {
    if (!beads.sizes[i * 2]) continue;
    look(beads.points, i * 3);
    look(beads.points, i * 3 + 3);
  }
  if (!replay) {
    const pose = facts.poses[state.pose];
    stuff.parts.forEach(({ points }, k) => {
      if (!pose || pose.fresh.includes(k) || pose.before.includes(k)) for (let i = 0; i < points.length; i += 3) look(points, i);
    });
  }
  return best?.point ?? onTable(x, y, at);
}

/** Where the line of sight meets the table's surface, table frame. */
function onTable(x, y, at) {
  const canvas = byId('canvas'), { eye } = camera.matrices(1), half = Math.tan(camera.fov / 2);
  const u = ((x / canvas.clientWidth) * 2 - 1) * half * (canvas.clientWidth / canvas.clientHeight), v = (1 - (y / canvas.clientHeight) * 2) * half;
  const ray = plus(plus(plus([0, 0, 0], camera.back, -1), camera.right, u), cross(camera.back, camera.right), v);
  const back = inverted(at.fromTable), from = moved(back, eye), along = turned(back, ray);
  return Math.abs(along[2]) < 1e-9 || from[2] / -along[2] < 0 ? null : plus(from, along, -from[2] / along[2]);
}

function pointer(canvas) {
  const down = new Map();
  let travelled = 0;
  const place = (event) => [event.offsetX, event.offsetY];
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, place(event));
    travelled = 0;
  });
  canvas.addEventListener('pointermove', (event) => {
    const last = down.get(event.pointerId);
    if (!last) return;
    const [x, y] = place(event), [dx, dy] = [x - last[0], y - last[1]];
    travelled += Math.abs(dx) + Math.abs(dy);
    if (down.size === 2) pinch(down, event.pointerId, [x, y]);
    down.set(event.pointerId, [x, y]);
    if (down.size === 2 || event.shiftKey || event.buttons & 2) pan(dx, dy);
    else orbit(-dx * 0.008, dy * 0.008);
  });
  const up = (event) => {
    if (down.delete(event.pointerId) && travelled < 4 && event.type === 'pointerup' && state.measuring) measure(...place(event));
  };
  canvas.addEventListener('pointerup', up);
  canvas.addEventListener('pointercancel', up);
  canvas.addEventListener('wheel', (event) => { event.preventDefault(); zoom(Math.exp(Math.sign(event.deltaY) * 0.12)); }, { passive: false });
}

function pinch(down, moving, to) {
  const other = [...down].find(([id]) => id !== moving)[1], from = down.get(moving);
  const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
  zoom(apart(from) / apart(to));
}

function orbit(yaw, pitch) {
  camera.yaw += yaw;
  camera.pitch = Math.min(1.5707, Math.max(-1.5707, camera.pitch + pitch));
  invalidate();
}

function pan(dx, dy) {
  const mm = (camera.distance * 2 * Math.tan(camera.fov / 2)) / byId('canvas').clientHeight, up = cross(camera.back, camera.right);
  camera.target = plus(plus(camera.target, camera.right, -dx * mm), up, dy * mm);
  invalidate();
}

function zoom(by) {
  camera.distance = Math.min(20000, Math.max(1, camera.distance * by));
  invalidate();
}

function look(yaw, pitch) {
  [camera.yaw, camera.pitch] = [yaw, pitch];
  invalidate();
}

/** The first click begins a distance, the second ends it. */
function measure(x, y) {
  const point = picked(x, y);
  if (!point) return;
  state.points = state.points.length === 2 ? [point] : [...state.points, point];
  const [a, b] = state.points;
  byId('status').textContent = b ? `distance ${Math.hypot(...plus(b, a, -1)).toFixed(2)} mm` : 'click the second point';
  invalidate();
}

/** Letters of axes, the measured distance and the place of a finding, over the picture. */
function labels(at) {
  const made = [], put = (point, text, name) => {
    const where = onPage(point);
    if (!where) return;
    const label = element('span', text, name);
    Object.assign(label.style, { left: `${where[0]}px`, top: `${where[1]}px` });
    made.push(label);
  };
  if (state.machine) axes(facts.machine, at).forEach((axis) => put(moved(at.fromMachine, axis.ends[1]), axis.label));
  if (state.place) put(moved(at.fromTable, state.place), '', 'place');
  const near = nearest();
  if (near) put(moved(at.fromTable, plus(near.head_mm, plus(near.other_mm, near.head_mm, -1), 0.5)), `${facts.verify.clearance_mm.toFixed(2)} mm`, 'distance near');
  const [a, b] = state.points;
  if (a && !b) put(moved(at.fromTable, a), '+', 'distance');
  if (b) put(moved(at.fromTable, plus(a, plus(b, a, -1), 0.5)), `${Math.hypot(...plus(b, a, -1)).toFixed(2)} mm`, 'distance');
  byId('labels').replaceChildren(...made);
}

function cycle(id) {
  const list = byId(id), open = [...list.options].filter((option) => !option.disabled);
  list.value = open[(open.indexOf(list.selectedOptions[0]) + 1) % open.length].value;
  list.dispatchEvent(new Event('change'));
}

function nextFinding(by) {
  const count = facts.verify?.findings.length ?? 0;
  if (count) showFinding(((state.finding ?? (by > 0 ? -1 : 0)) + by + count) % count);
}

/** Key, what it does in words, and how; those of programs are left out where there is none. */
function keyList() {
  const step = (by) => () => seek(state.move + by), layer = (by) => () => seekLayer(replay.layerOf(state.move) + by);
  const always = [
    ['v', 'table view or machine view', () => setView(!state.table)], ['h', 'head, frame and axes', () => toggle('machine')],
    ['f', 'all in sight', fit], ['m', 'measure', () => toggle('measuring')], ['d', 'dark or light', () => { setTheme(!state.dark); invalidate(); }],
    ['1', 'from the front', () => look(-Math.PI / 2, 0)], ['2', 'from the right', () => look(0, 0)], ['3', 'from above', () => look(-Math.PI / 2, 1.5707)],
    ['4', 'from a corner', () => look(-0.9, 0.45)], ['ArrowLeft', 'turn left', () => orbit(-0.1, 0)], ['ArrowRight', 'turn right', () => orbit(0.1, 0)],
    ['ArrowUp', 'turn up', () => orbit(0, 0.1)], ['ArrowDown', 'turn down', () => orbit(0, -0.1)], ['+', 'nearer', () => zoom(0.85)], ['-', 'farther', () => zoom(1.18)],
    ['w', 'move the picture up', () => pan(0, 40)], ['x', 'move it down', () => pan(0, -40)], ['a', 'move it left', () => pan(-40, 0)], ['e', 'move it right', () => pan(40, 0)],
    ['k', 'next pose', () => facts.poses.length && showPose((state.pose + 1) % facts.poses.length)], ['?', 'these keys', () => byId('help').showModal()],
  ];
  const program = [
    [' ', 'play or pause', () => play(!state.playing)], ['.', 'next move', step(1)], [',', 'previous move', step(-1)], ['PageUp', 'next layer', layer(1)],
    ['PageDown', 'previous layer', layer(-1)], ['Home', 'beginning', () => seek(0, 0)], ['End', 'end', () => seek(replay.count - 1)], ['c', 'next colour', () => cycle('colour')],
    ['s', 'next speed', () => cycle('speed')], ['t', 'travels and pose changes', () => toggle('travels')], ['o', "the parts' own surfaces", () => toggle('parts')],
    ['l', 'this layer alone', () => toggle('oneLayer')], ['g', 'go to a line', () => byId('goto').select()], ['n', 'next finding', () => nextFinding(1)], ['p', 'previous finding', () => nextFinding(-1)],
  ];
  return replay ? [...program, ...always] : always;
}

function keys() {
  const all = keyList(), names = { ' ': 'Space' };
  all.forEach(([key, what]) => {
    const row = element('tr'), cell = element('td');
    cell.append(element('kbd', names[key] ?? key));
    row.append(cell, element('td', what));
    byId('keys').append(row);
  });
  document.addEventListener('keydown', (event) => {
    const inside = event.target.closest?.('input, select, dialog'), button = event.target.closest?.('button');
    if (event.ctrlKey || event.altKey || event.metaKey || (inside && event.key !== 'Escape') || (button && event.key === ' ')) return;
    if (event.key === 'Escape') document.activeElement?.blur();
    const act = all.find(([key]) => key === event.key)?.[2];
    if (!act) return;
    event.preventDefault();
    act();
  });
}
