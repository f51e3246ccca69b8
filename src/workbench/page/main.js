// The page: rooms, what each shows of the state, and what its buttons ask for. Nothing is decided here that the command decides.

import { added, aim, askCuts, besideOf, cutting, forget, movedTo, pinned, planes, settledAt, turnedTo, without } from './cuts.js';
import { foot } from './foot.js';
import { deck, howPanel } from './how.js';
import { machineBox, machineFacts, modelPanel } from './model.js';
import { ask, asked, dragging, moved, place } from './order.js';
import { button, h, morph } from './parts.js';
import { busyWith, printPanel, printing } from './print.js';
import { Scene } from './scene.js';
import { previewOf, seePanel } from './see.js';
import { get, hasSecret, listen, post } from './server.js';
import { TEXTS } from './texts.js';

const ROOMS = ['model', 'how', 'see', 'print'];
const byId = (id) => document.getElementById(id);
const page = { room: 'model', state: null, machines: { machines: null, own: null }, drawn: null, drawnFor: undefined, uploads: [], copied: false, ended: false, frame: null, line: 0, slides: false, printer: 1 };
let scene = null;

function toast(text, kind = 'bad') {
  byId('toast').textContent = text ?? '';
  byId('toast').className = kind;
  byId('toast').hidden = !text;
}

/** Asks for a change of the state that is shown; what is refused is said. */
async function change(path, query = {}, body = undefined) {
  try {
    toast(null);
    hear(await post(path, { revision: page.state.revision, ...query }, body));
    return true;
  } catch (error) {
    toast(error.message);
    if (error.code === 'workbench/old-revision') hear(await get('state'));
    return false;
  }
}

const ACTIONS = {
  room: ({ room }) => go(room),
  line: ({ line }) => showLine(Number(line)),
  add: () => byId('file').click(),
  remove: ({ index }) => change('remove', { index }),
  pick: () => pick(scene?.picking === 'up' ? null : 'up'),
  'pick-cut': () => pick(scene?.picking === 'cut' ? null : 'cut'),
  'pin-cut': ({ cut }) => recut(pinned(page.state, Number(cut))),
  uncut: ({ cut }) => recut(without(page.state, Number(cut))),
  'free-cuts': () => recut([]),
  'drop-cut': () => { forget(); show(); },
  way: ({ way }) => change('set', { name: 'way', value: way }),
  undo: () => change('undo'),
  redo: () => change('redo'),
  save: () => save(),
  reorder: ({ card, by }) => reorder(card, place(page.state, card) + Number(by)),
  'free-order': () => { asked.refused = null; change('set', { name: 'order', value: 'auto' }); },
  find: () => change('run', { task: 'prepare' }),
  run: ({ task }) => change('run', { task }),
  stop: ({ task }) => change('word', { task, word: 'stop' }),
  word: ({ task, word }) => change('word', { task, word }),
  printer: ({ printer }) => { Object.assign(page, { printer: Number(printer), line: 0 }); show(); },
  'add-printer': () => addPrinter(),
  'remove-printer': ({ printer }) => change('remove-printer', { index: printer }),
  copy: async () => {
    const text = byId('command').textContent;
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      getSelection().selectAllChildren(byId('command'));
      document.execCommand('copy');
    }
    page.copied = text;
    show();
  },
  quit: async () => {
    if (await change('quit')) {
      page.ended = true;
      toast(TEXTS.ended);
      connection(TEXTS.ended);
    }
  },
};

/** One more printer, which is the one that is shown. */
async function addPrinter() {
  const before = page.state.printers.map((one) => one.number);
  if (!(await change('add-printer'))) return;
  const added = page.state.printers.find((one) => !before.includes(one.number));
  if (added) ACTIONS.printer({ printer: added.number });
}

/** Asks for a change that the command may refuse: why, or null where it was made. */
async function refusal(path, value) {
  try {
    toast(null);
    const { refused, ...state } = await post(path, { revision: page.state.revision, value });
    hear(state);
    return refused;
  } catch (error) {
    if (error.code === 'workbench/old-revision') hear(await get('state'));
    return { error: error.message, code: error.code, reasons: [] };
  }
}

/** Asks for another order of the prints, and for nothing where a card is where it was. */
async function reorder(card, to) {
  const cards = page.state.timeline && !asked.cards && moved(page.state, card, to);
  if (!cards) return;
  const focus = document.activeElement?.id;
  await ask(cards, card, (value) => refusal('order', value), show);
  if (asked.refused) byId('order-why')?.scrollIntoView({ block: 'nearest' });
  // A button that was off meanwhile has lost it.
  if (focus) (byId(focus)?.disabled ? byId(`print-${card}`)?.querySelector('button:not(:disabled)') : byId(focus))?.focus();
}

/** Asks for these cuts, or else for one of `others`, and for nothing where they are as they were. */
async function recut(pins, others = []) {
  if (!pins || cutting.waits) return;
  const focus = document.activeElement?.id;
  await askCuts(pins, others, (value) => refusal('cuts', value), show);
  if (cutting.refused) byId('cut-why')?.scrollIntoView({ block: 'nearest' });
  const focused = focus && byId(focus);
  focused?.focus();
  // It is where its plane is, and not where the pointer let it go.
  if (focused?.type === 'range') focused.value = focused.getAttribute('value');
}

/** Asks for one more cut: without an offset across the middle. */
function add(normal, offset) {
  const [pins, ...others] = added(page.state, normal, offset);
  return recut(pins, others);
}

/** Saves the project; the file can be fetched in the room of models. */
async function save() {
  if (await change('save')) toast(TEXTS.saved(page.state.file.name), 'good');
}

/** The next click on the picture chooses a face: to lie on (`up`), or to be cut along (`cut`). */
function pick(what) {
  if (scene) scene.pick(what);
  show();
}

/** A face was clicked: the direction out of it, and where it is along that. */
function picked({ normal, offset, ...place }) {
  const what = scene.picking;
  if (what === 'cut' && !aim(page.state, place)) return;
  if (what === 'up') change('set', { name: 'up', value: normal.map((v) => -v + 0).join() }).then(() => pick(null));
  else add(normal, offset).then(() => pick(null));
}

/** A plane is somewhere while somebody holds its slider or its arrow; nobody is asked before it is let go. */
function hold(k, offset) {
  cutting.held = { k, offset };
  for (const id of [`slide-${k}`, `offset-${k}`]) if (byId(id) && byId(id) !== document.activeElement) byId(id).value = offset;
  scene?.setPlanes(planes(page.state));
}

/** Where a plane comes to lie whose slider or number says so: what is typed, and what keys say, is meant to the digit. */
const settles = ({ dataset, value }) => (page.slides ? settledAt(page.state, Number(dataset.offset), Number(value)) : value);

/** The arrow of a plane was dragged: it comes to lie along a face or an edge that is near. */
function slid(k, offset, done) {
  if (cutting.waits) return;
  const start = Number(byId(`offset-${k}`)?.getAttribute('value')), at = offset === start ? start : settledAt(page.state, k, offset);
  if (!done) return hold(k, at);
  cutting.held = null;
  if (at === start) return show();
  return recut(movedTo(page.state, k, at));
}

async function upload(files) {
  for (const file of files) {
    page.uploads.push(file.name);
    show();
    await change('models', { name: file.name }, file);
    page.uploads.splice(page.uploads.indexOf(file.name), 1);
    show();
  }
}

function go(room) {
  page.room = room;
  show();
}

function rooms() {
  const { state } = page, tab = (room) => {
    const here = room === page.room, busy = room === 'see' ? state?.runs.prepare?.running : room === 'print' && state?.printers.some((one) => busyWith(state, one.number)[1]);
    const stale = (room === 'see' && state?.prepared?.stale) || (room === 'how' && state?.ways?.stale);
    return h('button', { id: `room-${room}`, type: 'button', role: 'tab', 'aria-selected': String(here), 'aria-controls': 'panel', tabindex: here ? '0' : '-1', 'data-do': 'room', 'data-room': room, title: TEXTS.roomHints[room] },
      h('kbd', { 'aria-hidden': 'true', text: String(ROOMS.indexOf(room) + 1) }),
      h('strong', { text: TEXTS.rooms[room] }),
      busy ? h('i', { class: 'dot busy' }) : stale ? h('i', { class: 'dot warn', title: TEXTS.stale }) : null);
  };
  morph(byId('rooms'), ROOMS.map(tab));
}

/** Undo and redo, and what they would change. */
function steps() {
  const step = (which, sign) => {
    const one = page.state[which], says = one ? `${TEXTS.steps[which]}: ${TEXTS.stepNames[one.what](one.name)}` : TEXTS.noStep[which];
    return button(which, sign, { id: which, class: 'quiet round', disabled: !one, 'aria-label': says, title: `${says} (${TEXTS.stepKeys[which]})`, 'aria-keyshortcuts': TEXTS.stepKeys[which].replace('Ctrl', 'Control') });
  };
  const { file } = page.state, unsaved = page.state.models.length > 0 && !file.saved;
  const says = file.name ? `${TEXTS.saveTitle}. ${file.name}: ${unsaved ? TEXTS.savedBefore : TEXTS.savedNow}` : TEXTS.saveTitle;
  morph(byId('steps'), step('undo', '↶'), step('redo', '↷'),
    button('save', TEXTS.save, { id: 'save', class: 'quiet', disabled: page.state.models.length === 0, title: `${says} (${TEXTS.saveKey})`, 'aria-keyshortcuts': 'Control+S' }));
}

function panel() {
  const { state, room } = page;
  if (room === 'model') return [...modelPanel(state, page.uploads, scene?.picking === 'up'), ...machineFacts(state, page.machines, page.drawn)];
  return room === 'how' ? howPanel(state, scene?.picking === 'cut') : room === 'see' ? seePanel(state) : printPanel(state, page.printer);
}

/** The preview has a frame of its own, which stays while nothing of the file changes. */
function frame() {
  const address = previewOf(page.state), box = byId('frame-box'), made = page.state.prepared?.document.verify?.seconds;
  const wanted = address && `${address} ${made}`, shown = Boolean(address) && (page.room === 'see' || page.room === 'print');
  // Not before it is seen: its picture takes its size from the frame.
  if (page.frame !== wanted && (shown || !address)) {
    page.frame = wanted;
    const inside = address && h('iframe', { id: 'preview', title: TEXTS.preview, sandbox: 'allow-scripts', src: address });
    box.replaceChildren(...(inside ? [inside] : []));
  }
  box.hidden = !shown;
  byId('canvas').hidden = shown || !scene;
  byId('caption').hidden = shown || !scene || !page.state.models.length;
  byId('no-gl').hidden = shown || Boolean(scene);
}

/** Shows a line of the program in the preview, which takes nothing else from here. */
function showLine(line) {
  byId('preview')?.contentWindow.postMessage(JSON.stringify({ line }), '*');
}

/** The preview goes with the print. */
function follow() {
  const [, run] = printing(page.state, page.printer), line = run?.progress?.line;
  if (!line || line === page.line) return;
  page.line = line;
  showLine(line);
}

/** Everything that is shown, from the state. */
function show() {
  rooms();
  if (!page.state) return;
  if (page.copied !== false && page.copied !== byId('command')?.textContent) page.copied = false;
  document.body.dataset.room = page.room;
  steps();
  morph(byId('machine-box'), machineBox(page.state, page.machines));
  byId('folder').textContent = TEXTS.folder(page.state.folder.split(/[\\/]/).filter(Boolean).pop() ?? page.state.folder);
  byId('folder').title = page.state.folder;
  morph(byId('panel'), panel());
  byId('panel').setAttribute('aria-labelledby', `room-${page.room}`);
  byId('deck').hidden = page.room !== 'how';
  if (page.room === 'how') morph(byId('deck'), deck(page.state));
  foot(byId('foot'), page.room, page.state, page.printer, page.copied !== false);
  const cuts = page.room === 'how' ? planes(page.state) : [];
  scene?.setPlanes(cuts);
  byId('caption').textContent = cuts.length ? TEXTS.captionCuts : scene?.hangs ? TEXTS.caption(Math.round(scene.steepest)) : TEXTS.captionPlain;
  frame();
}

/** The server has told its state. */
function hear(state) {
  // An answer may come behind an event that is newer.
  if (page.state && state.version < page.state.version) return;
  // Why an order was refused concerns the project as it was then.
  if (page.state && state.revision !== page.state.revision) {
    Object.assign(asked, { refused: null, sprung: null });
    if (!cutting.waits) forget();
  }
  page.state = state;
  // It may have been removed by another page.
  if (!state.printers.some((one) => one.number === page.printer)) Object.assign(page, { printer: 1, line: 0 });
  connection('');
  show();
  follow();
  draw();
  if (page.machines.machines === null) machines();
}

async function machines() {
  page.machines = await get('machines').catch(() => page.machines);
  show();
}

const keyOf = (model) => JSON.stringify([model.path, page.state.unit, page.state.plate, page.state.up, model.inspected?.parts?.map((part) => [part.facets, part.volume_mm3])]);

/** Fetches what is to be drawn and is not there yet. */
async function draw() {
  if (!scene) return;
  const { state } = page;
  if (page.drawnFor !== state.machine) {
    page.drawnFor = state.machine;
    const drawn = await get('machine').catch(() => null);
    if (page.drawnFor !== state.machine) return; // another was chosen meanwhile, and is on its way
    page.drawn = drawn;
    scene.setMachine(page.drawn);
    page.keys = null;
    show();
  }
  const models = page.state.models.filter((model) => model.inspected?.parts).map((model) => ({ key: keyOf(model) })), keys = JSON.stringify(models);
  if (page.state.models.length !== models.length && page.state.models.some((model) => !model.inspected)) return;
  if (page.keys === keys) return;
  page.keys = keys;
  const { revision, up } = page.state;
  if (!(await scene.setModels(page.state.models.map((model) => ({ key: keyOf(model) })), revision, up))) {
    page.keys = null;
    // The new state may be here already, or is on its way.
    if (page.state.revision !== revision) return draw();
  }
  return show();
}

function connection(text) {
  byId('link-state').textContent = text;
}

/** Ctrl+S, Ctrl+Z, Ctrl+Shift+Z and Ctrl+Y. What is being typed has an undo of its own. */
function stepKey(event) {
  const letter = event.key.toLowerCase();
  if (letter === 's' && !event.altKey && !event.shiftKey && page.state) {
    event.preventDefault();
    // What is being typed is part of it.
    event.target.blur?.();
    if (page.state.models.length) save();
    return;
  }
  const which = letter === 'y' || (letter === 'z' && event.shiftKey) ? 'redo' : letter === 'z' ? 'undo' : null;
  if (!which || event.altKey || !page.state || event.target.closest?.('input:not([type="range"]), textarea')) return;
  event.preventDefault();
  if (page.state[which]) change(which);
  else toast(`${TEXTS.noStep[which]}.`);
}

function events() {
  document.addEventListener('click', (event) => {
    const target = event.target.closest?.('[data-do]');
    if (target && !target.disabled) ACTIONS[target.dataset.do](target.dataset);
  });
  document.addEventListener('change', (event) => {
    const { target } = event;
    if (target.id === 'file') {
      upload([...target.files]).then(() => { target.value = ''; });
    } else if (target.dataset.set) {
      change('set', { name: target.dataset.set, value: target.value });
    } else if (target.dataset.addCut !== undefined) {
      const normal = target.value;
      target.value = '';
      if (normal) add(normal.split(','));
    } else if (target.dataset.offset) {
      recut(movedTo(page.state, Number(target.dataset.offset), settles(target)));
      page.slides = false;
    } else if (target.dataset.angle) {
      recut(turnedTo(page.state, Number(target.dataset.cut), target.dataset.angle, target.value, (normal, offset, part) => scene?.middleOf(normal, offset, part)));
    } else if (target.dataset.cutPart !== undefined) {
      cutting.part = Number(target.value);
      show();
    } else if (target.dataset.copies) {
      change('copies', { index: target.dataset.copies, value: target.value });
    }
  });
  document.addEventListener('pointerdown', ({ target }) => { page.slides = target.type === 'range'; });
  document.addEventListener('input', ({ target }) => {
    if (!target.dataset.offset || target.value === '') return;
    hold(Number(target.dataset.offset), settles(target));
  });
  document.addEventListener('keydown', (event) => {
    page.slides = false;
    if (event.key === 'Escape' && scene?.picking) pick(null);
    if (event.ctrlKey || event.metaKey) return stepKey(event);
    const by = event.target.type === 'range' && event.target.dataset.offset && { PageUp: 1, PageDown: -1 }[event.key];
    if (by) {
      const k = Number(event.target.dataset.offset), at = besideOf(page.state, k, by);
      event.preventDefault();
      if (at !== null && !cutting.waits) recut(movedTo(page.state, k, at));
    }
    if (event.altKey || event.target.closest?.('input, select, textarea')) return;
    const number = ROOMS[Number(event.key) - 1], at = ROOMS.indexOf(page.room);
    const next = event.target.closest?.('[role="tab"]') && { ArrowDown: ROOMS[(at + 1) % 4], ArrowUp: ROOMS[(at + 3) % 4] }[event.key];
    if (!number && !next) return;
    event.preventDefault();
    go(number ?? next);
    byId(`room-${number ?? next}`).focus();
  });
  dragging(byId('deck'), () => page.state, reorder);
  dropping();
  window.addEventListener('focus', () => page.state && !page.ended && get('state').then(hear, () => {}));
}

/** Files can be dropped anywhere. */
function dropping() {
  let inside = 0;
  const over = (by) => { inside = Math.max(0, inside + by); byId('drop').hidden = inside === 0; };
  document.addEventListener('dragenter', (event) => { event.preventDefault(); over(1); });
  document.addEventListener('dragleave', () => over(-1));
  document.addEventListener('dragover', (event) => event.preventDefault());
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    over(-inside);
    upload([...event.dataTransfer.files]);
    go('model');
  });
}

function begin() {
  document.title = TEXTS.title;
  byId('quit').textContent = TEXTS.quit;
  byId('quit').title = TEXTS.quitTitle;
  byId('steps').setAttribute('aria-label', TEXTS.stepGroup);
  byId('drop').textContent = TEXTS.dropHere;
  byId('canvas').setAttribute('aria-label', TEXTS.sceneLabel);
  byId('no-gl').textContent = TEXTS.noGl;
  rooms();
  events();
  if (!hasSecret) return toast(TEXTS.noSecret);
  try {
    scene = new Scene(byId('canvas'), picked, slid);
    cutting.stops = (normal, part) => scene.stops(normal, part);
  } catch {
    byId('no-gl').hidden = false;
  }
  connection(TEXTS.connecting);
  return listen(hear, (text) => { connection(text ?? TEXTS.lost); if (text) toast(text); }, () => page.ended);
}

begin();

/** For programs that drive the page. */
window.workbench = { page, showLine, get scene() { return scene; } };
