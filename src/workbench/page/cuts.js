// The planes along which the models are cut: those that somebody has decided, and those that the plan found. Whether one can be made is what the
// command says: one that cannot stays where it was put, in red, with the reason. Lengths are mm, places those of the part's own file.

import { button, choice, h, notice, number } from './parts.js';
import { anglesOf, leaning, settled, stopBeside } from './planes.js';
import { TEXTS } from './texts.js';

/**
 * What is shown beside the state: cuts that are asked for, and why they were refused; where a plane is while its slider or its arrow is held; which part
 * is cut next; and, of the picture, where planes of a direction lie along a part.
 */
export const cutting = { asked: null, waits: false, refused: null, held: null, part: 0, stops: () => [] };

/** The words of a cut, as `--cut` has them: numbers stay as they are written. Without one the only part is cut. */
function read(pin) {
  const [part, words] = pin.includes(':') ? pin.split(':') : [null, pin], [plane, ...points] = words.split('@'), numbers = plane.split(',');
  return { part, normal: numbers.slice(0, 3), offset: numbers[3], points };
}

const write = ({ part, normal, offset, points }) => (part === null ? '' : `${part}:`) + [[...normal, offset].join(), ...points].join('@');
const unit = (normal) => { const v = normal.map(Number), long = Math.hypot(...v); return v.map((x) => x / long); };
const short = (value) => String(Number(value.toFixed(4)));
const inHundredths = (degrees) => Number(degrees.toFixed(2));

/** The chosen cuts as they are shown now: as they are, or as somebody has just put them. */
const chosen = (state) => cutting.asked ?? state.cuts;

/**
 * The parts that can be cut: what no other one touches. Of each its number in the plan (of the first copy), how many numbers its copies have and which
 * of their steps; where it is, in the models and in that model; its name and its box.
 */
function partsOf(state) {
  const all = [];
  let first = 0;
  state.models.forEach(({ path, copies, inspected }, model) => {
    const parts = inspected?.parts ?? [], touched = new Set((inspected?.interfaces ?? []).flatMap(({ a, b }) => [a, b])), file = path.split(/[/\\]/).pop();
    parts.forEach(({ name, box_mm: box }, part) => {
      const own = { number: first + part, step: parts.length, end: first + parts.length * copies, model, part, box };
      if (!touched.has(part)) all.push({ ...own, name: parts.length > 1 ? `${file}: ${name}` : file });
    });
    first += parts.length * copies;
  });
  return all;
}

/** The part that a cut is of: whichever copy it names. */
function partOf(state, { part }) {
  const all = partsOf(state), number = Number(part ?? 0);
  return all.find((one) => number >= one.number && number < one.end && (number - one.number) % one.step === 0);
}

/** Whether there are several parts, copies aside, so that a cut says of which it is. */
const several = (state) => state.models.reduce((sum, { inspected }) => sum + (inspected?.parts?.length ?? 0), 0) > 1;

/** The part that the next plane cuts. */
const nextPart = (state) => partOf(state, { part: cutting.part }) ?? partsOf(state)[0];

/** What is known of the solid that a part was cut as. */
const solidOf = (state, { number, end, step }) => state.cut.find(({ of_parts: parts }) => parts.some((one) => one >= number && one < end && (one - number) % step === 0));

/** Planes that the plan has found behind the chosen ones: in which solid each is, and as the how manieth. */
function found(state) {
  if (cutting.asked) return [];
  return state.cut.flatMap(({ of_parts: [first], planes }) => {
    const part = partOf(state, { part: first }), mine = state.cuts.filter((pin) => partOf(state, read(pin))?.number === part?.number);
    return part ? planes.slice(mine.length).map((plane) => ({ ...plane, part })) : [];
  });
}

/** The area of a chosen cut's seam, mm², where it is known. */
function seamOf(state, k) {
  if (cutting.asked) return null;
  const numberOf = (pin) => partOf(state, read(pin))?.number, own = partOf(state, read(state.cuts[k]));
  const before = state.cuts.slice(0, k).filter((pin) => numberOf(pin) === own?.number).length;
  return own ? solidOf(state, own)?.planes[before]?.seam_mm2 : null;
}

/** Whether cuts can be chosen: of models as they were drawn, with a part that nothing touches. */
const possible = (state) => state.models.length > 0 && state.up === 'auto' && state.models.every(({ inspected }) => inspected?.parts) && partsOf(state).length > 0;

/** Whether a chosen cut is the one that was refused; all of them, where nobody says which. */
const isBad = (k) => cutting.refused !== null && (cutting.refused.cut ?? k) === k;

const placeOf = ({ model, part }) => ({ model, part });

/** Every plane, to be drawn: its normal, where it is along that, what it is, and which part it cuts. */
export function planes(state) {
  if (!possible(state)) return [];
  const of = (pin, k) => {
    const cut = read(pin), part = partOf(state, cut);
    return part && { normal: unit(cut.normal), offset: Number(cutting.held?.k === k ? cutting.held.offset : cut.offset), kind: isBad(k) ? 'bad' : 'chosen', k, ...placeOf(part) };
  };
  const theirs = found(state).map(({ normal, offset_mm: offset, part }) => ({ normal, offset, kind: 'found', ...placeOf(part) }));
  return [...chosen(state).map(of).filter(Boolean), ...theirs];
}

/** From where to where planes of this direction meet a part, mm. */
function span({ box: [low, high] }, normal) {
  const n = unit(normal);
  const side = (a, b) => n.reduce((sum, v, i) => sum + v * (v > 0 ? a[i] : b[i]), 0);
  return [side(low, high), side(high, low)];
}

function along(normal) {
  const n = unit(normal), axis = n.findIndex((v) => Math.abs(v) > 1 - 1e-9);
  if (axis >= 0) return `${n[axis] < 0 ? '-' : '+'}${'XYZ'[axis]}`;
  const { lean, towards } = anglesOf(n);
  return TEXTS.leaning(number(lean, 0), number(towards, 0));
}

/** The part of a plane, where there are several. */
const ofPart = (state, part) => several(state) && h('span', { class: 'soft', text: part.name });

/** What stands for a cut of nothing that can be cut. */
const nowhere = { box: [[0, 0, 0], [0, 0, 0]], name: '' };

function chosenRow(state, pin, k) {
  const cut = read(pin), { normal, offset } = cut, part = partOf(state, cut) ?? nowhere, [low, high] = span(part, normal), seam = seamOf(state, k);
  const name = TEXTS.plane(k + 1), stops = cutting.stops(unit(normal), part), angles = anglesOf(unit(normal));
  const at = { min: short(low), max: short(high), step: 'any', value: offset, 'data-offset': k, disabled: cutting.waits, 'aria-label': TEXTS.cutAt(name) };
  const angle = (which, min, max) => h('label', { class: 'field', for: `${which}-${k}`, title: TEXTS.cutAngleTitles[which] }, h('span', { text: TEXTS.cutAngles[which] }),
    h('input', { id: `${which}-${k}`, type: 'number', min, max, step: 5, value: inHundredths(angles[which]), 'data-angle': which, 'data-cut': k, disabled: cutting.waits, 'aria-label': `${name}, ${TEXTS.cutAngleTitles[which]}` }));
  return h(
    'li',
    { id: `cut-${k}`, class: `card cut ${isBad(k) ? 'bad' : 'chosen'}` },
    h('div', { class: 'card-head' }, h('strong', { text: `${name}: ${along(normal)}` }),
      button('uncut', '×', { id: `uncut-${k}`, class: 'quiet round', 'data-cut': k, disabled: cutting.waits, 'aria-label': TEXTS.removeCut(name), title: TEXTS.removeCut(name) })),
    ofPart(state, part),
    h('div', { class: 'row' },
      h('input', { id: `slide-${k}`, type: 'range', list: `stops-${k}`, title: TEXTS.cutSlide, 'aria-keyshortcuts': 'PageUp PageDown', ...at }),
      h('input', { id: `offset-${k}`, type: 'number', ...at })),
    h('datalist', { id: `stops-${k}` }, stops.map((stop) => h('option', { value: stop }))),
    h('div', { class: 'row' }, angle('lean', 0, 180), angle('towards', 0, 360)),
    typeof seam === 'number' && h('span', { class: 'soft', text: TEXTS.seamOf(number(seam, 0)) }),
  );
}

function foundRow(state, plane, k) {
  return h(
    'li',
    { id: `found-${k}`, class: 'card cut found' },
    h('div', { class: 'card-head' }, h('strong', { text: `${TEXTS.plane(k + 1)}: ${along(plane.normal)} ${number(plane.offset_mm)} mm` }),
      button('pin-cut', TEXTS.pinCut, { id: `pin-${k}`, 'data-cut': k, disabled: cutting.waits, title: TEXTS.pinCutTitle })),
    ofPart(state, plane.part),
    h('span', { class: 'soft', text: `${TEXTS.foundCut} · ${TEXTS.seamOf(number(plane.seam_mm2, 0))}` }),
  );
}

/** The section of the room of ways; nothing before there is a model that can be cut. */
export function cutsPanel(state, picking) {
  if (state.models.length === 0 || (!possible(state) && state.cuts.length === 0)) return [];
  const head = h('h3', { text: TEXTS.cutsTitle });
  if (!possible(state)) return [head, notice('note', TEXTS.cutsNotNow), button('free-cuts', TEXTS.cutsAuto, { id: 'free-cuts' })];
  const mine = chosen(state), theirs = found(state), waiting = state.cuts.length > 0 && !['auto', 'cut'].includes(state.way);
  const directions = [['', TEXTS.addCutNone], ...['1,0,0', '-1,0,0', '0,1,0', '0,-1,0', '0,0,1'].map((normal) => [normal, along(normal.split(','))])];
  const { refused } = cutting, left = cutting.asked ? 0 : state.cut.reduce((sum, { left_mm2: mm2 }) => sum + mm2, 0);
  const which = partsOf(state), next = nextPart(state);
  return [
    head, h('p', { class: 'soft', text: TEXTS.cutsHint }),
    waiting && notice('note', TEXTS.cutsWait),
    h('ol', { id: 'cuts', class: 'cards', 'aria-label': TEXTS.cutsTitle, 'aria-busy': String(cutting.waits) }, mine.map((pin, k) => chosenRow(state, pin, k)), theirs.map((plane, k) => foundRow(state, plane, k + mine.length))),
    h('div', { id: 'cut-why' }, refused ? notice('bad', TEXTS.cutRefused, refused.error, refused.code && h('p', {}, h('code', { text: TEXTS.code(refused.code) }))) : null),
    refused && button('drop-cut', TEXTS.dropCut, { id: 'drop-cut' }),
    left > 0.5 && h('p', { class: 'soft', role: 'status', text: TEXTS.cutLeft(number(left, 0)) }),
    which.length > 1 && choice('cut-part', TEXTS.cutPart, String(next.number), which.map((part) => [String(part.number), part.name]), { 'data-set': null, 'data-cut-part': true, disabled: cutting.waits }),
    button('pick-cut', TEXTS.cutFace, { id: 'pick-cut', 'aria-pressed': String(picking), class: picking ? 'primary' : null, disabled: cutting.waits }),
    picking && h('p', { class: 'soft', role: 'status', text: TEXTS.cutPicking }),
    choice('add-cut', TEXTS.addCut, '', directions, { 'data-set': null, 'data-add-cut': true, disabled: cutting.waits }),
    mine.length > 0 && !refused && button('free-cuts', TEXTS.cutsAuto, { id: 'free-cuts', disabled: cutting.waits }),
  ];
}

/** What is cut off is not cut again: of planes in one direction the outer ones come first. */
function inOrder(pins) {
  const made = [], along = ({ part, normal }) => `${part}:${normal}`;
  for (const pin of pins) {
    const cut = read(pin), inner = made.map(read).findIndex((one) => along(one) === along(cut) && Number(one.offset) < Number(cut.offset));
    made.splice(inner < 0 ? made.length : inner, 0, pin);
  }
  return made;
}

/** The cuts with one more: last where that can be, and else the later the better, for a plane through what another one cuts off has to come before that. */
export function added(state, normal, offset) {
  const part = nextPart(state), named = several(state) ? part.number : null;
  const pin = write({ part: named, normal, offset: offset ?? short(span(part, normal).reduce((a, b) => a + b) / 2), points: [] });
  const usual = inOrder([...chosen(state), pin]), place = usual.indexOf(pin), rest = usual.filter((_, i) => i !== place);
  const before = (at) => [...rest.slice(0, at), pin, ...rest.slice(at)];
  return [usual, ...rest.slice(0, place).map((_, k) => before(place - 1 - k))];
}

/** The cuts with one that the plan found. */
export const pinned = (state, k) => inOrder([...state.cuts, found(state)[k - state.cuts.length].pin]);

/** The next plane cuts the part that was clicked; false where that cannot be cut. */
export function aim(state, { model, part }) {
  const one = partsOf(state).find((each) => each.model === model && each.part === part);
  if (one) cutting.part = one.number;
  return Boolean(one);
}

export const without = (state, k) => chosen(state).filter((_, i) => i !== k);

/** Where a plane that is moved by hand comes to lie: along a face or an edge that is near. */
export function settledAt(state, k, offset) {
  const cut = read(chosen(state)[k]), part = partOf(state, cut) ?? nowhere, [low, high] = span(part, cut.normal);
  return settled(offset, cutting.stops(unit(cut.normal), part), high - low);
}

/** Where the next face or edge behind a plane is (`by` 1), or before it (-1); null where there is none. */
export function besideOf(state, k, by) {
  const cut = read(chosen(state)[k]);
  return stopBeside(Number(cut.offset), cutting.stops(unit(cut.normal), partOf(state, cut) ?? nowhere), by);
}

/** The cuts with one of them turned about `middle`, the middle of what it cuts, which is a function of where it is. */
export function turnedTo(state, k, which, value, middle) {
  const pins = [...chosen(state)], { part, normal, offset, points } = read(pins[k]), before = anglesOf(unit(normal));
  if (value === '' || !Number.isFinite(Number(value)) || Number(value) === inHundredths(before[which])) return null;
  const turned = leaning({ ...before, [which]: Number(value) }), through = middle(unit(normal), Number(offset), partOf(state, { part }) ?? nowhere);
  if (!through) return null;
  pins[k] = write({ part, normal: turned, offset: short(turned.reduce((sum, v, i) => sum + v * through[i], 0) + 0), points });
  return pins;
}

/** The cuts with one of them elsewhere along its direction; what it takes is named by points, which go with it. */
export function movedTo(state, k, offset) {
  const pins = [...chosen(state)], { part, normal, offset: before, points } = read(pins[k]), n = unit(normal), by = Number(offset) - Number(before);
  if (!by || !Number.isFinite(by)) return null;
  const shifted = points.map((point) => point.split(',').map((v, i) => short(Number(v) + by * n[i])).join());
  pins[k] = write({ part, normal, offset: short(Number(offset)), points: shifted });
  return inOrder(pins);
}

/** Asks for these cuts, and where they cannot be made for `others` one after the other; those that cannot either stay, with the reason of the first. */
export async function askCuts(pins, others, post, show) {
  Object.assign(cutting, { asked: pins, waits: true, refused: null, held: null });
  show();
  let refused = await post(pins.length ? pins.join(';') : 'auto');
  for (const other of refused?.code === 'split/refused-cut' ? others : []) {
    if (await post(other.join(';'))) continue;
    refused = null;
    break;
  }
  Object.assign(cutting, { asked: refused ? pins : null, waits: false, refused });
  show();
}

/** Nothing is asked any more. */
export const forget = () => Object.assign(cutting, { asked: null, refused: null, held: null });
