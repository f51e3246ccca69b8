// The strip at the foot: the command line of what the page shows, to be copied.

import { button, h, morph } from './parts.js';
import { busyWith, taskOf } from './print.js';
import { TEXTS } from './texts.js';

/** The command that stands for the room: its line, or what is missing. */
function current(room, state, printer) {
  if (room === 'model') return state.inspect.length ? { line: state.inspect[state.inspect.length - 1] } : { why_not: state.commands.prepare.why_not };
  if (room !== 'print') return state.commands.prepare;
  const [, running] = busyWith(state, printer);
  if (running) return { line: running.command };
  const [print, publish, rehearse] = ['print', 'publish', 'rehearse'].map((name) => state.commands[taskOf(name, printer)]);
  return [print, publish].find((command) => command.line) ?? rehearse;
}

export function foot(element, room, state, printer, copied) {
  const { line, why_not: missing } = current(room, state, printer);
  morph(
    element,
    h('span', { class: 'prompt', 'aria-hidden': 'true', text: '$' }),
    h('code', { id: 'command', tabindex: line ? '0' : null, 'aria-label': TEXTS.command, class: line ? null : 'missing', text: line ?? TEXTS.notYet(missing ?? '') }),
    button('copy', copied ? TEXTS.copied : TEXTS.copy, { id: 'copy', title: TEXTS.copyTitle, disabled: !line }),
  );
}
