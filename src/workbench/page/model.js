// The room of models: what was added, and the machine.

import { button, choice, failure, h, notice } from './parts.js';
import { TEXTS } from './texts.js';

const name = (path) => path.split(/[/\\]/).pop();

/** The size of all parts together, mm. */
function size({ parts }) {
  const low = [0, 1, 2].map((k) => Math.min(...parts.map((part) => part.box_mm[0][k])));
  return [0, 1, 2].map((k) => Math.max(...parts.map((part) => part.box_mm[1][k])) - low[k]);
}

function details(inspected, notes) {
  const { parts, unit, floating } = inspected, facets = parts.reduce((sum, part) => sum + part.facets, 0);
  const told = inspected.warnings?.length ? inspected.warnings : notes.filter((line) => line.startsWith('warning: ')).map((line) => line.slice(9));
  const row = (part) => h('li', {}, h('span', { text: part.name }), h('span', { text: `${(part.volume_mm3 / 1000).toFixed(1)} cm³` }));
  return [
    h('p', { class: 'size', text: `${size(inspected).map((v) => v.toFixed(1)).join(' × ')} mm` }),
    h('p', { class: 'soft', text: [TEXTS.parts(parts.length), TEXTS.facets(facets), TEXTS.closed, unit].join(' · ') }),
    floating.length > 0 && notice('warn', TEXTS.inAir(floating.length)),
    told.length > 0 && notice('note', TEXTS.mended, null, h('ul', {}, told.map((text) => h('li', { text })))),
    parts.length > 1 && h('details', {}, h('summary', { text: TEXTS.partList }), h('ul', { class: 'part-list' }, parts.map(row))),
  ];
}

function card(model, index) {
  const { inspected } = model, called = name(model.path);
  const body = !inspected ? h('p', { class: 'soft busy', text: TEXTS.reading }) : inspected.error ? failure(inspected, TEXTS.code) : details(inspected, model.notes);
  return h(
    'li',
    { class: 'card' },
    h('div', { class: 'card-head' }, h('strong', { title: model.path, text: called }),
      button('remove', '×', { class: 'quiet round', 'data-index': index, 'aria-label': TEXTS.removeTitle(called), title: TEXTS.removeTitle(called) })),
    body,
    h('label', { class: 'field inline', for: `copies-${index}` }, h('span', { text: TEXTS.copies }),
      h('input', { id: `copies-${index}`, type: 'number', min: '1', max: '999', value: model.copies, 'data-copies': index })),
  );
}

/** Which way up: by name, or by the face that was clicked. */
function standing(state, picking) {
  const known = Object.entries(TEXTS.ups), own = known.some(([value]) => value === state.up) ? [] : [[state.up, TEXTS.upChosen]];
  return [
    choice('up', TEXTS.up, state.up, [...known, ...own]),
    button('pick', TEXTS.pick, { id: 'pick', 'aria-pressed': String(picking), class: picking ? 'primary' : null }),
    picking && h('p', { class: 'soft', role: 'status', text: TEXTS.picking }),
  ];
}

/** The project's file, to be fetched. */
function projectFile({ file }) {
  if (!file.name) return null;
  return h('div', { class: 'files' }, h('h3', { text: TEXTS.projectFile }),
    h('a', { class: 'file', id: 'file-project', href: `/files/${encodeURIComponent(file.name)}`, download: file.name },
      h('span', { text: file.name }), h('span', { class: 'soft', text: file.saved ? TEXTS.savedNow : TEXTS.savedBefore })));
}

export function modelPanel(state, uploads, picking) {
  return [
    h('h2', { text: TEXTS.rooms.model }),
    h('div', { class: 'dropzone' }, button('add', TEXTS.addModels, { id: 'add', class: 'primary' }), h('p', { class: 'soft', text: TEXTS.dropHint })),
    uploads.map((file) => h('p', { class: 'soft busy', text: TEXTS.uploading(file) })),
    h('ul', { class: 'cards', id: 'models' }, state.models.map(card)),
    state.models.length > 0 && standing(state, picking),
    // Slicers' projects alone have plates.
    state.models[0]?.path.toLowerCase().endsWith('.3mf') && choice('plate', TEXTS.plate, state.plate, [['auto', TEXTS.plateAuto], ...Array.from({ length: state.choices.plates }, (_, k) => [String(k + 1), String(k + 1)])]),
    state.models.length > 0 && choice('unit', TEXTS.unit, state.unit, state.choices.unit.map((unit) => [unit, unit === 'auto' ? TEXTS.unitAuto : unit])),
    projectFile(state),
  ];
}

/** The machine, in the header: every room needs it. */
export function machineBox(state, { machines, own }) {
  const listed = machines ?? [], text = (row) => [row.file ?? row.name, row.name];
  const [theirs, shipped] = [listed.filter((row) => row.file), listed.filter((row) => !row.file)];
  const unlisted = [...new Set([own, state.machine])].filter((one) => one && !listed.some((row) => (row.file ?? row.name) === one));
  const extra = unlisted.map((one) => [one, one === own ? `${name(one)} (${TEXTS.ownMachine})` : name(one)]);
  const options = [
    ...(state.machine ? [] : [['', TEXTS.noMachine]]), ...extra,
    ...(theirs.length ? [{ group: TEXTS.own, options: theirs.map(text) }] : []), { group: TEXTS.shipped, options: shipped.map(text) },
  ];
  return choice('machine', TEXTS.machine, state.machine ?? '', options);
}

/** What is known of the machine. */
export function machineFacts(state, { machines }, drawn) {
  const row = (machines ?? []).find((one) => (one.file ?? one.name) === state.machine);
  if (drawn?.error) return [h('h3', { text: TEXTS.machine }), failure(drawn, TEXTS.code)];
  if (!row) return [];
  const [x, y] = row.largest_level_mm ?? [];
  return [
    h('h3', { text: TEXTS.machine }),
    h('p', { text: row.about ?? row.name }),
    row.error && notice('bad', row.error),
    x && h('p', { class: 'soft', text: TEXTS.table(Math.round(x), Math.round(y)) }),
    row.tested_on?.length === 0 && h('p', { class: 'soft', text: TEXTS.untested }),
  ];
}
