// The room of the prepared file: progress, proof, figures, files, and the preview in its frame.

import { button, failure, figures, h, notice, number, time } from './parts.js';
import { TEXTS } from './texts.js';

/** How far a running job is, and the button that stops it. */
export function progress(run, task) {
  const { bar } = run, last = run.notes[run.notes.length - 1];
  return h(
    'div',
    { class: 'progress', role: 'status' },
    h('div', { class: 'progress-head' }, h('strong', { class: 'busy', text: bar ? bar.what : TEXTS.working }), button('stop', TEXTS.stop, { id: 'stop', 'data-task': task })),
    h('progress', bar ? { value: bar.at, max: Math.max(bar.of, 1) } : {}),
    last && h('p', { class: 'soft', text: last }),
  );
}

/** What a job has written beside its result. */
export function log(run) {
  if (!run?.notes.length) return null;
  return h('details', { class: 'log' }, h('summary', { text: TEXTS.log }), h('pre', { tabindex: '0', text: run.notes.join('\n') }));
}

function findings({ findings: list }) {
  if (!list?.length) return notice('good', TEXTS.verified);
  const line = (one) => one.line > 0 && button('line', `${TEXTS.line} ${one.line}`, { 'data-line': one.line, title: TEXTS.showLine });
  const row = (one) => h('li', {}, h('strong', { text: one.rule }), ` ${one.text ?? ''} `, line(one));
  return notice('bad', TEXTS.findings(list.length), null, h('ol', { id: 'findings' }, list.map(row)));
}

/** The sheet of figures. */
function sheet(document) {
  const { verify, plan, slicer, ways } = document, way = (ways ?? []).find((one) => one.chosen);
  return figures([
    way && [TEXTS.way, TEXTS.ways[way.way] ?? way.way],
    [TEXTS.printTime, time(verify.seconds_print)],
    [TEXTS.filament, `${number(verify.filament_mm / 1000, 2)} m${way ? `, ${number(way.grams)} g` : ''}`],
    [TEXTS.clearance, `${number(verify.clearance_mm, 2)} mm`],
    [TEXTS.slots, number(verify.slots, 0)],
    [TEXTS.setups, number(plan.pose_changes, 0)],
    [TEXTS.moves, verify.moves.toLocaleString('en')],
    slicer && [TEXTS.slicedBy, slicer.name],
  ]);
}

function files(state) {
  const ends = ['gcode', 'plan.json', 'html'];
  const link = (end, i) => h('a', { class: 'file', id: `file-${end.split('.')[0]}`, href: `/files/${encodeURIComponent(state.files[i])}`, ...(end === 'html' ? { target: '_blank', rel: 'noopener' } : { download: state.files[i] }) },
    h('span', { text: TEXTS.files[end] }), h('span', { class: 'soft', text: state.files[i] }));
  return h('div', { class: 'files' }, h('h3', { text: TEXTS.download }), ends.map(link));
}

function result(state) {
  const { document, stale } = state.prepared;
  if (stale) return [notice('stale', TEXTS.stale, TEXTS.staleFile)];
  // Where the proof has failed there is a report, too, but no file and no plan beside it.
  if (document.output) {
    const warnings = document.warnings ?? [];
    return [findings(document.verify), sheet(document), warnings.length > 0 && notice('warn', TEXTS.warnings, null, h('ul', {}, warnings.map((one) => h('li', { text: one.text ?? String(one) })))), files(state)];
  }
  const failed = document.verify ?? document;
  if (failed.findings) return [findings(failed), h('p', { class: 'soft', text: TEXTS.notWritten })];
  if (document.summary) return [notice('bad', document.summary, null, reasons(document), document.code && h('p', {}, h('code', { text: TEXTS.code(document.code) })))];
  return [failure(document, TEXTS.code)];
}

/** Why there is no plan, and what would help. */
function reasons({ reasons: why, remedies }) {
  const list = (rows) => rows?.length > 0 && h('ul', {}, rows.map((row) => h('li', { text: row.text ?? String(row) })));
  return [list(why), list(remedies)];
}

export function seePanel(state) {
  const run = state.runs.prepare, { why_not: missing } = state.commands.prepare, { prepared } = state;
  const again = prepared ? TEXTS.prepareAgain : TEXTS.prepare, fresh = prepared && !prepared.stale && prepared.document.output;
  return [
    h('h2', { text: TEXTS.seeTitle }),
    missing && notice('note', TEXTS.notYet(missing)),
    !prepared && !missing && h('p', { class: 'soft', text: TEXTS.notPreparedHint }),
    run?.running ? progress(run, 'prepare') : button('find', again, { id: 'prepare', class: fresh ? null : 'primary', disabled: Boolean(missing) || state.busy }),
    prepared && !run?.running ? result(state) : null,
    log(run),
  ];
}

/** Where the preview of the file as it is now can be fetched; null without one. */
export function previewOf(state) {
  const { prepared, files: names } = state;
  const shown = prepared && !prepared.stale && !state.runs.prepare?.running && (prepared.document.verify || prepared.document.findings);
  return shown ? `/files/${encodeURIComponent(names[2])}` : null;
}
