// The room of the print: rehearse, print, pause, continue, end.

import { button, failure, figures, h, notice, number, time } from './parts.js';
import { log, progress } from './see.js';
import { TEXTS } from './texts.js';

const degrees = (now, wanted) => `${number(now, 0)}${wanted ? ` / ${number(wanted, 0)}` : ''} °C`;

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

const field = (name, value, label, hint) => h('label', { class: 'field', for: name }, h('span', { text: label }), h('input', { id: name, 'data-set': name, value, placeholder: hint, spellcheck: 'false', autocomplete: 'off' }));

/** What has become of an upload. */
function uploaded(run) {
  if (!run || run.running) return null;
  const { published: done, failed } = run;
  if (done) return [notice('good', TEXTS.published(done.file, done.url, done.uploads > 0), done.started ? TEXTS.started : null), log(run)];
  return [failed && failure(failed, TEXTS.code), log(run)];
}

/** The print by way of a server: its address, its key, the buttons, and the last upload. */
function publishing(state, off) {
  const [task, run] = Object.entries(state.runs).find(([name]) => name.startsWith('publish')) ?? [];
  return h('section', {}, h('h3', { text: TEXTS.publishTitle }), h('p', { class: 'soft', text: TEXTS.publishHint }),
    field('server', state.server, TEXTS.server, TEXTS.serverHint), field('key_file', state.key_file, TEXTS.keyFile, TEXTS.keyFileHint),
    (state.server.includes('https://') || state.fingerprint !== '') && field('fingerprint', state.fingerprint, TEXTS.fingerprint, TEXTS.fingerprintHint),
    h('div', { class: 'row' }, button('run', TEXTS.publish, { id: 'publish', 'data-task': 'publish', disabled: off('publish') }), button('run', TEXTS.publishAndStart, { id: 'publish-and-start', 'data-task': 'publish-and-start', disabled: off('publish-and-start') })),
    run?.running ? progress(run, task) : uploaded(run));
}

export function printPanel(state) {
  const { print, resume, rehearse } = state.runs, { commands, busy } = state;
  const [task, run] = [['resume', resume], ['print', print]].find(([, one]) => one?.running) ?? ['print', null];
  const missing = commands.rehearse.why_not, off = (name) => busy || Boolean(commands[name].why_not);
  return [
    h('h2', { text: TEXTS.printTitle }),
    missing && notice('note', TEXTS.notYet(missing)),
    run && [live(run, task), log(run)],
    !run && [
      h('section', {}, h('p', { class: 'soft', text: TEXTS.rehearseHint }), button('run', TEXTS.rehearse, { id: 'rehearse', 'data-task': 'rehearse', disabled: off('rehearse') }), rehearsal(rehearse)),
      h('section', {}, field('port', state.port, TEXTS.port, TEXTS.portHint),
        h('div', { class: 'row' }, button('run', TEXTS.print, { id: 'print', class: 'primary', 'data-task': 'print', disabled: off('print') }), button('run', TEXTS.resume, { id: 'resume', 'data-task': 'resume', disabled: off('resume') })),
        ended(resume ?? print)),
      publishing(state, off),
    ],
  ];
}
