// The room of the print: rehearse, print, pause, continue, end.

import { button, failure, figures, h, notice, number, time } from './parts.js';
import { log, progress } from './see.js';
import { TEXTS } from './texts.js';

const degrees = (now, wanted) => `${number(now, 0)}${wanted ? ` / ${number(wanted, 0)}` : ''} °C`;

/** The name of a printer's task: of the first it is plain. */
export const taskOf = (name, printer) => (printer === 1 ? name : `${name}:${printer}`);

/** The last run of a printer's task. */
const runOf = ({ runs }, name, printer) => runs[taskOf(name, printer)];

/** What a printer does now: the names of its tasks in order of what matters. */
const DOES = ['resume', 'print', 'publish-and-start', 'publish', 'rehearse'];

/** The run that a printer is busy with, and its task; none where it is free. */
export function busyWith(state, printer) {
  return DOES.map((name) => [taskOf(name, printer), runOf(state, name, printer)]).find(([, run]) => run?.running) ?? [];
}

/** The same of a print, which goes on for long and can be paused. */
export function printing(state, printer) {
  const [task, run] = busyWith(state, printer);
  return ['print', 'resume'].some((name) => task === taskOf(name, printer)) ? [task, run] : [];
}

/** A printer in a word or two. */
function doing(state, printer) {
  const [, run] = printing(state, printer);
  if (!run && busyWith(state, printer)[1]) return TEXTS.working;
  if (!run) return runOf(state, 'resume', printer) ?? runOf(state, 'print', printer) ? TEXTS.printerEnded : TEXTS.printerFree;
  const percent = `${Math.floor((run.progress?.share ?? 0) * 100)} %`;
  return run.asks ? TEXTS.printerAsks : run.paused ? `${TEXTS.paused}, ${percent}` : percent;
}

const printerName = ({ number: n, name }) => name || TEXTS.printer(n);

/** All printers, of which one is chosen, and what it is called. */
function printers(state, chosen) {
  const several = state.printers.length > 1, own = state.printers.find((one) => one.number === chosen);
  const card = (one) => h('button', { id: `printer-${one.number}`, type: 'button', class: 'printer-card', 'data-do': 'printer', 'data-printer': one.number, 'aria-pressed': String(one.number === chosen) },
    h('strong', { text: printerName(one) }), h('span', { class: 'soft', text: doing(state, one.number) }));
  return h('section', {}, several && h('div', { class: 'printers', role: 'group', 'aria-label': TEXTS.printers }, state.printers.map(card)),
    several && field(taskOf('printer_name', chosen), own.name, TEXTS.printerName, TEXTS.printer(chosen)),
    h('div', { class: 'row' }, button('add-printer', TEXTS.addPrinter, { id: 'add-printer', class: 'quiet', title: TEXTS.addPrinterTitle }),
      several && chosen !== 1 && button('remove-printer', TEXTS.removePrinter, { id: 'remove-printer', class: 'quiet', 'data-printer': chosen, disabled: Boolean(busyWith(state, chosen)[1]) })));
}

/** A print under way: how far it is, and what can be done. */
function live(run, task) {
  const { progress: at, paused, asks } = run, word = (name, text, attributes = {}) => button('word', text, { id: `word-${name}`, 'data-task': task, 'data-word': name, ...attributes });
  const share = at?.share ?? 0;
  return h(
    'div',
    { class: 'progress', role: 'status' },
    h('div', { class: 'progress-head' }, h('strong', { class: paused ? null : 'busy', text: paused ? TEXTS.paused : TEXTS.printing }), h('span', { class: 'percent', text: `${Math.floor(share * 100)} %` })),
    h('progress', { value: share, max: 1 }),
    at && figures([
      [TEXTS.left, time(at.seconds_left)], [TEXTS.layer, `${at.layer} / ${at.layers}`], [TEXTS.line, `${at.line} / ${at.of}`],
      at.nozzle_c !== null && [TEXTS.nozzle, degrees(at.nozzle_c, at.nozzle_target_c)], at.bed_c !== null && [TEXTS.bed, degrees(at.bed_c, at.bed_target_c)],
      at.waits_for && [TEXTS.waits, at.waits_for],
    ]),
    asks && notice('warn', TEXTS.asks, null, word('yes', TEXTS.yes)),
    h('div', { class: 'row' }, paused ? [word('continue', TEXTS.continue, { class: 'primary' }), word('cancel', TEXTS.cancel)] : word('pause', TEXTS.pause, { class: 'primary' }),
      word('stop', TEXTS.emergency, { class: 'danger', title: TEXTS.emergencyTitle })),
    h('p', { class: 'soft', text: TEXTS.closing }),
  );
}

/** How a print has ended. */
function ended(run) {
  if (!run || run.running) return null;
  if (run.event?.event === 'done' && run.exit === 0) return notice('good', TEXTS.printDone);
  if (run.event?.event === 'stopped') return [notice('warn', TEXTS.printStopped, run.event.reason), log(run)];
  return [run.failed ? failure(run.failed, TEXTS.code) : notice('warn', TEXTS.printStopped), log(run)];
}

function rehearsal(run) {
  if (!run || run.running) return null;
  if (run.event?.event === 'done' && run.exit === 0) return notice('good', TEXTS.rehearsed(time(run.event.seconds)));
  return run.failed ? failure(run.failed, TEXTS.code) : null;
}

function field(name, value, label, hint) {
  const id = name.replace(':', '-');
  return h('label', { class: 'field', for: id }, h('span', { text: label }), h('input', { id, 'data-set': name, value, placeholder: hint, spellcheck: 'false', autocomplete: 'off' }));
}

/** What has become of an upload. */
function uploaded(run) {
  if (!run || run.running) return null;
  const { published: done, failed } = run;
  if (done) return [notice('good', TEXTS.published(done.file, done.url, done.uploads > 0), done.started ? TEXTS.started : null), log(run)];
  return [failed && failure(failed, TEXTS.code), log(run)];
}

/** The print by way of a server: its address, its key, the buttons, and the last upload. */
function publishing(state, own, does, set) {
  const [task, run] = ['publish', 'publish-and-start'].map((name) => [taskOf(name, own.number), runOf(state, name, own.number)]).find(([, one]) => one) ?? [];
  return h('section', {}, h('h3', { text: TEXTS.publishTitle }), h('p', { class: 'soft', text: TEXTS.publishHint }),
    set('server', TEXTS.server, TEXTS.serverHint), set('key_file', TEXTS.keyFile, TEXTS.keyFileHint),
    (own.server.includes('https://') || own.fingerprint !== '') && set('fingerprint', TEXTS.fingerprint, TEXTS.fingerprintHint),
    h('div', { class: 'row' }, does('publish', TEXTS.publish), does('publish-and-start', TEXTS.publishAndStart)),
    run?.running ? progress(run, task) : uploaded(run));
}

export function printPanel(state, chosen) {
  const { commands, runs } = state, own = state.printers.find((one) => one.number === chosen);
  const [task, run] = printing(state, chosen), missing = commands.rehearse.why_not;
  const busy = Boolean(busyWith(state, chosen)[1]) || runs.prepare?.running;
  const does = (name, text, attributes = {}) => button('run', text, { id: name, 'data-task': taskOf(name, chosen), disabled: busy || Boolean(commands[taskOf(name, chosen)].why_not), ...attributes });
  const set = (name, label, hint) => field(taskOf(name, chosen), own[name], label, hint);
  return [
    h('h2', { text: TEXTS.printTitle }),
    missing && notice('note', TEXTS.notYet(missing)),
    printers(state, chosen),
    run && [live(run, task), log(run)],
    !run && [
      h('section', {}, h('p', { class: 'soft', text: TEXTS.rehearseHint }), does('rehearse', TEXTS.rehearse), rehearsal(runOf(state, 'rehearse', chosen))),
      h('section', {}, set('port', TEXTS.port, TEXTS.portHint),
        h('div', { class: 'row' }, does('print', TEXTS.print, { class: 'primary' }), does('resume', TEXTS.resume)),
        ended(runOf(state, 'resume', chosen) ?? runOf(state, 'print', chosen))),
      publishing(state, own, does, set),
    ],
  ];
}
