// What is read and pressed around the picture. Names and sentences come from files of others: they are set as text, never as HTML.

const SPEEDS = [1, 10, 60, 300, 1000, 5000];
const ROW = 18; // height of a line of the text, pixels

function element(tag, text = '', name = '') {
  const made = document.createElement(tag);
  made.textContent = text;
  if (name) made.className = name;
  return made;
}

function setTheme(dark) {
  state.dark = dark;
  document.documentElement.classList.toggle('dark', dark);
  byId('theme').textContent = dark ? 'Light' : 'Dark';
}

function duration(seconds) {
  const all = Math.floor(seconds), two = (v) => String(v).padStart(2, '0');
  return `${Math.floor(all / 3600)}:${two(Math.floor(all / 60) % 60)}:${two(all % 60)}`;
}

const counted = (count, word) => `${count.toLocaleString('en')} ${word}${count === 1 ? '' : 's'}`;

/** Fills everything that stays, and ties the controls to what they do. */
function panels() {
  document.title = `${facts.file} - trunnion preview`;
  byId('title').textContent = byId('title').title = facts.file;
  byId('summary').textContent = summary();
  waysTable();
  findingsList();
  posesList();
  const pressed = (id, act) => byId(id).addEventListener('click', act);
  pressed('view-table', () => setView(true));
  pressed('view-machine', () => setView(false));
  pressed('show-travels', () => toggle('travels'));
  pressed('show-machine', () => toggle('machine'));
  pressed('show-parts', () => toggle('parts'));
  pressed('one-layer', () => toggle('oneLayer'));
  pressed('measure', () => toggle('measuring'));
  pressed('fit', fit);
  pressed('theme', () => { setTheme(!state.dark); invalidate(); });
  pressed('help-open', () => byId('help').showModal());
  pressed('play', () => play(!state.playing));
  if (!replay) return hideProgram();
  Object.entries(modes).forEach(([id, mode]) => byId('colour').append(new Option(mode.title, id)));
  // What is not known is said.
  if (!modes.clearance) byId('colour').append(Object.assign(new Option(replay.count > facts.program.surveyed_moves ? 'Clearance: too many moves, only the least is known' : 'Clearance: no print has any', ''), { disabled: true }));
  byId('colour').addEventListener('change', () => { state.mode = byId('colour').value; recolour(); });
  SPEEDS.forEach((speed) => byId('speed').append(new Option(`${speed} x`, speed, speed === state.speed, speed === state.speed)));
  byId('speed').addEventListener('change', () => { state.speed = Number(byId('speed').value); });
  byId('time').max = replay.seconds;
  byId('time').addEventListener('input', () => {
    const { move, share } = replay.whenAt(Number(byId('time').value));
    seek(move, share);
  });
  byId('layer').max = Math.max(0, replay.layers.length - 1);
  byId('layer').addEventListener('input', () => seekLayer(Number(byId('layer').value)));
  byId('goto').max = replay.facts.lines;
  byId('goto').addEventListener('change', () => seekLine(Number(byId('goto').value) || 1));
  byId('text').addEventListener('wheel', (event) => { event.preventDefault(); seekLine(currentLine() + Math.sign(event.deltaY) * 3); }, { passive: false });
  new ResizeObserver(followText).observe(byId('text'));
}

/** A plan alone has no times, no layers and no text. */
function hideProgram() {
  ['text-section', 'show-travels', 'one-layer', 'show-parts'].forEach((id) => { byId(id).hidden = true; });
  document.body.classList.add('planned');
  byId('colour').parentElement.hidden = true;
  document.querySelector('footer').hidden = true;
}

/** What the picture shows, for those who cannot see it. */
function summary() {
  const { verify, machine, program } = facts;
  const of = `${counted(facts.parts.filter(({ role }) => role === 'solid').length, 'part')} on ${machine.name}`;
  if (facts.kind === 'reasons') return `${of}, and no plan: ${facts.why_not}. Each entry below is the nearest miss of one part.`;
  const poses = counted(facts.poses.length, 'pose');
  if (!program) return `A plan for ${of}, ${poses}; nothing is sliced yet.`;
  const found = Object.values(verify.counts).reduce((sum, n) => sum + n, 0);
  const near = verify.clearance_line ? `The least clearance of the head is ${verify.clearance_mm.toFixed(2)} mm, at line ${verify.clearance_line}.` : 'The head stays 50 mm and more away from everything.';
  return `${of}, ${poses}, ${counted(program.moves, 'move')} in ${counted(replay.layers.length, 'layer')} and ${counted(program.lines, 'line')}. `
    + `About ${duration(program.seconds)} hours without heating, ${(verify.filament_mm / 1000).toFixed(2)} m of filament. `
    + `${found ? `Verification has ${counted(found, 'finding')}.` : 'Verification has no findings.'} ${near}`
    + (facts.thinned ? ' The parts are drawn with fewer facets than they have.' : '')
    + (program.has_text ? '' : ' The lines of the file would make this page too large and are not in it.');
}

function entry(list, act, ...content) {
  const item = element('li'), button = element('button');
  button.append(...content);
  button.addEventListener('click', act);
  item.append(button);
  list.append(item);
  return button;
}

/** The ways to print the model beside each other, the one that was taken first; nothing where there was only one. */
function waysTable() {
  if (facts.ways.length < 2) return;
  byId('ways-section').hidden = false;
  const row = (tag, cells) => {
    const line = element('tr');
    line.append(...cells.map((text) => element(tag, text)));
    byId('ways').append(line);
    return line;
  };
  row('th', ['way', 'price', 'print', 'filament', 'supports', 'seams', 'setups', 'stands']);
  for (const way of facts.ways) {
    const told = (value, digits, unit) => (value === null ? '' : `${Math.max(0, value).toFixed(digits)} ${unit}`);
    const line = row('td', [
      way.way, told(way.price_min, 0, 'min'), told(way.minutes, 0, 'min'), told(way.grams, 1, 'g'), told(way.support_g, 1, 'g'), told(way.seam_mm2, 0, 'mm²'),
      way.setups === null ? '' : String(way.setups), way.stands === null ? '' : `${way.stands.toFixed(1)} times`,
    ]);
    if (way.chosen) line.setAttribute('aria-current', 'true');
    if (way.why_not) {
      const why = element('td', way.why_not, 'why');
      why.colSpan = 8;
      const below = element('tr');
      below.append(why);
      byId('ways').append(below);
    }
  }
}

function findingsList() {
  const { verify } = facts, list = byId('findings');
  if (!verify) {
    byId('findings-section').hidden = true;
    return;
  }
  const total = Object.values(verify.counts).reduce((sum, n) => sum + n, 0);
  byId('findings-title').textContent = total > verify.findings.length ? `Findings: ${total}, the first ones of each rule` : `Findings: ${total || 'none'}`;
  verify.findings.forEach((finding, i) => {
    const part = facts.parts[finding.part]?.name;
    const where = `line ${finding.line}${part === undefined ? '' : `, ${part}`} `;
    const button = entry(list, () => showFinding(i), element('span', where), element('span', finding.rule, 'rule'), element('span', `: ${finding.text}`));
    button.dataset.line = finding.line;
    button.dataset.rule = finding.rule;
  });
  if (verify.clearance_line) {
    const button = entry(list, () => showPlace(verify.clearance_line, verify.clearance_at), element('span', `line ${verify.clearance_line}: least clearance ${verify.clearance_mm.toFixed(2)} mm`));
    button.id = 'clearance';
  }
}

function showFinding(i) {
  state.finding = i;
  showPlace(facts.verify.findings[i].line);
  document.querySelectorAll('#findings button').forEach((button, k) => button.setAttribute('aria-current', k === i));
}

/** Goes to a line, and brings the tip there, or what it comes near to, to the middle. */
function showPlace(line, near = null) {
  play(false);
  seekLine(line);
  if (near) seek(state.move, near.share, line);
  const at = now();
  if (near || !at.tip.includes(null)) {
    state.place = near ? near.other_mm : moved(at.back, at.tip);
    camera.target = moved(at.fromTable, state.place);
    camera.distance = Math.min(camera.distance, 160);
  }
  seen();
}

function posesList() {
  const { tilt, rotation } = facts.machine, short = (v) => String(Math.round(v * 100) / 100);
  byId('poses-title').textContent = facts.kind === 'reasons' ? 'What stands in the way' : 'Poses';
  facts.poses.forEach((pose, i) => {
    const angles = `${tilt.letter}${short(pose.words_deg[0])} ${rotation.letter}${short(pose.words_deg[1])}`;
    const what = pose.slot === null ? `${facts.parts[pose.fresh[0]].name} at ${angles}: ` : `slot ${pose.slot}, ${angles}: `;
    entry(byId('poses'), () => showPose(i), element('span', what), element('span', pose.text));
  });
}

/** A pose: of a plan its picture, of a program the first line laid there. */
function showPose(i) {
  state.pose = i;
  if (replay) {
    const { slot, angles } = facts.poses[i], near = (a, b) => a !== null && Math.abs(a - b) < 1e-6;
    const there = replay.places.map((place) => place.slot === slot && near(place.tilt, angles[0]) && near(place.rotation, angles[1]));
    const first = replay.layers.find((move) => there[replay.place[move]]);
    if (first !== undefined) seek(first);
  }
  document.querySelectorAll('#poses button').forEach((button, k) => button.setAttribute('aria-current', k === i));
  seen();
}

function setView(table, fits = true) {
  state.table = table;
  byId('view-table').setAttribute('aria-pressed', table);
  byId('view-machine').setAttribute('aria-pressed', !table);
  if (fits) fit();
  else invalidate();
}

const BUTTONS = { travels: 'show-travels', machine: 'show-machine', parts: 'show-parts', oneLayer: 'one-layer', measuring: 'measure' };
function toggle(what) {
  state[what] = !state[what];
  byId(BUTTONS[what]).setAttribute('aria-pressed', state[what]);
  byId('canvas').classList.toggle('measuring', state.measuring);
  if (what === 'measuring') state.points = [];
  invalidate();
}

function seekLayer(layer) {
  const last = replay.layers.length - 1;
  if (last < 0) return;
  const at = Math.min(Math.max(0, layer), last);
  seek(at < last ? replay.layers[at + 1] - 1 : replay.count - 1);
}

function showLegend(legend) {
  const box = byId('legend');
  box.replaceChildren(element('b', legend.title + (legend.unit ? `, ${legend.unit}` : '')));
  const swatch = (width, height, colour, name = '') => {
    const canvas = Object.assign(element('canvas', '', name), { width, height }), context = canvas.getContext('2d');
    for (let y = 0; y < height; y++) {
      context.fillStyle = `rgb(${colour(1 - y / Math.max(1, height - 1)).join(',')})`;
      context.fillRect(0, y, width, 1);
    }
    return canvas;
  };
  legend.kinds?.forEach(({ name, colour }) => {
    const row = element('div');
    row.append(swatch(1, 1, () => colour), element('span', name));
    box.append(row);
  });
  if (legend.kinds) return;
  if (!(legend.high >= legend.low)) return box.append(element('div', 'not known'));
  const row = element('div'), ticks = element('div', '', 'ticks');
  [1, 0.75, 0.5, 0.25, 0].forEach((share) => ticks.append(element('span', (legend.low + (legend.high - legend.low) * share).toPrecision(3))));
  row.append(swatch(1, 64, onScale, 'bar'), ticks);
  box.append(row);
}

function partsLegend() {
  const grey = { name: facts.kind === 'reasons' ? 'other parts' : 'printed before', colour: PLAIN };
  if (facts.kind !== 'reasons') return { title: 'Parts', kinds: [{ name: 'printed here', colour: KINDS[5] }, grey] };
  return { title: 'Parts', kinds: [{ name: 'to be printed', colour: KINDS[5] }, { name: 'in the way', colour: KINDS[3] }, grey] };
}

const currentLine = () => (replay ? state.line || replay.line[state.move] : 0);

/** Sliders, words and text follow the state. */
function follow() {
  if (!replay) {
    const pose = facts.poses[state.pose];
    byId('status').textContent = pose ? pose.text : 'no pose to show';
    return;
  }
  const time = replay.timeOf(state.move, state.share), layer = replay.layerOf(state.move);
  byId('time').value = time;
  byId('clock').textContent = `${duration(time)} / ${duration(replay.seconds)}`;
  byId('layer').value = layer;
  byId('layer-said').textContent = `${replay.layers.length ? layer + 1 : 0} of ${replay.layers.length}`;
  if (document.activeElement !== byId('goto')) byId('goto').value = currentLine();
  byId('status').textContent = said();
  followText();
}

/** Where it is, in words. */
function said() {
  const { tip, tilt, rotation, place } = replay.frame(state.move, state.share), { machine } = facts;
  const word = (axis, angle) => (angle === null ? `${axis.letter}?` : `${axis.letter}${Math.round((((angle * 180) / Math.PI) * axis.direction + axis.zero_deg) * 100) / 100}`);
  const style = replay.facts.styles[replay.style[state.move]], part = style && facts.parts[replay.facts.prints[style[0]]?.[0]]?.name;
  const doing = replay.flags[state.move] & FLAG.lays ? style[1] : replay.flags[state.move] & FLAG.turns ? 'the table turns' : 'travel';
  const xyz = tip.map((v, k) => `${'XYZ'[k]}${v === null ? '?' : v.toFixed(2)}`).join(' ');
  return `line ${currentLine()}: ${doing}${part && place.zone === 'prints' ? `, ${part}` : ''}${place.slot === null ? '' : `, slot ${place.slot}`}; ${xyz} ${word(machine.tilt, tilt)} ${word(machine.rotation, rotation)}`;
}

/** The lines around the current one. */
function followText() {
  if (!replay) return;
  const box = byId('text'), rows = Math.max(3, Math.floor(box.clientHeight / ROW)), line = currentLine();
  if (!replay.facts.has_text) {
    box.replaceChildren(element('span', 'not in this page'));
    return;
  }
  const found = new Set(facts.verify.findings.map((finding) => finding.line));
  const first = Math.max(1, Math.min(line - (rows >> 1), replay.facts.lines - rows + 1));
  const made = [];
  for (let number = first; number < first + rows && number <= replay.facts.lines; number++) {
    const row = element('div', '', (number === line ? 'now ' : '') + (found.has(number) ? 'found' : ''));
    row.append(element('span', String(number), 'number'), element('span', replay.text(number)));
    row.setAttribute('role', 'option');
    row.setAttribute('aria-selected', number === line);
    row.addEventListener('click', () => seekLine(number));
    made.push(row);
  }
  box.replaceChildren(...made);
}
