// The prints in their order: cards on a line, which are dragged, or moved by their buttons. Whether an order works is what the command says.

import { button, h, notice, number, time } from './parts.js';
import { TEXTS } from './texts.js';

/** What is shown beside the state: an order that is being asked for, and why the last one was refused. */
export const asked = { cards: null, refused: null, sprung: null };

const MOST_NAMES = 3;

/** Parts of a card, as the command's option has them. */
const step = (print) => print.parts.join('+');

/** The cards as they are shown now: as in the plan, or as somebody has just put them. */
const shown = (state) => asked.cards ?? state.timeline.prints;

function pose(print) {
  if (Math.abs(print.tilt_deg) < 0.05) return TEXTS.upright;
  return TEXTS.tilted(number(print.tilt_deg, 0), number(print.rotation_deg, 0));
}

function card(print, index, all, waits) {
  const names = print.names.slice(0, MOST_NAMES).join(', ') + (print.names.length > MOST_NAMES ? ` +${print.names.length - MOST_NAMES}` : '');
  const key = step(print), move = (by, sign, says, off) => button('reorder', sign, { id: `${by < 0 ? 'earlier' : 'later'}-${key}`, class: 'quiet round', 'data-card': key, 'data-by': by, disabled: off || waits, 'aria-label': says(names), title: says(names) });
  return h(
    'li',
    { id: `print-${key}`, class: `print${asked.sprung === key ? ' sprung' : ''}`, 'data-card': key, title: TEXTS.dragHint },
    h('div', { class: 'card-head' }, h('strong', { text: `${index + 1}. ${names}` })),
    h('span', { class: 'soft', text: pose(print) }),
    h('span', { class: 'soft', text: TEXTS.about(time(print.seconds)) }),
    h('div', { class: 'row' }, move(-1, '←', TEXTS.earlier, index === 0), move(1, '→', TEXTS.later, index === all.length - 1)),
  );
}

/** The line of prints below the ways. */
export function orderLine(state) {
  if (!state.timeline) {
    return state.order === 'auto' ? null : [h('h3', { text: TEXTS.orderTitle }), notice('stale', TEXTS.stale, TEXTS.orderOld), free(state)];
  }
  const prints = shown(state), waits = asked.cards !== null;
  const head = [h('h3', { text: TEXTS.orderTitle }), prints.length > 1 && h('p', { class: 'soft', text: TEXTS.orderHint })];
  const cards = h('ol', { id: 'prints', class: 'prints', 'aria-label': TEXTS.orderTitle, 'aria-busy': String(waits) }, prints.map((print, i) => card(print, i, prints, waits)));
  const why = asked.refused && notice('bad', TEXTS.orderRefused, asked.refused.error, asked.refused.reasons.length > 1 && h('ul', {}, asked.refused.reasons.map((text) => h('li', { text }))), asked.refused.code && h('p', {}, h('code', { text: TEXTS.code(asked.refused.code) })));
  return [...head, cards, waits && h('p', { class: 'soft busy', role: 'status', text: TEXTS.orderAsked }), h('div', { id: 'order-why' }, why || null), free(state)];
}

const free = (state) => state.order !== 'auto' && button('free-order', TEXTS.orderAuto, { id: 'free-order' });

/** The cards with one of them at another place; null where that is where it is. */
export function moved(state, key, to) {
  const cards = [...shown(state)], from = cards.findIndex((print) => step(print) === key), place = Math.max(0, Math.min(to, cards.length - 1));
  if (from < 0 || from === place) return null;
  cards.splice(place, 0, ...cards.splice(from, 1));
  return cards;
}

export const place = (state, key) => shown(state).findIndex((print) => step(print) === key);

/** Has the cards in this order, if the command has a plan for it; else they spring back, and the reason is shown. */
export async function ask(cards, key, post, show) {
  Object.assign(asked, { cards, refused: null, sprung: null });
  show();
  const refused = await post(cards.map(step).join(','));
  Object.assign(asked, { cards: null, refused, sprung: refused ? key : null });
  show();
}

/** Cards can be dragged with a mouse, a pen or a finger. */
export function dragging(element, state, drop) {
  let key = null;
  const over = (event) => document.elementFromPoint(event.clientX, event.clientY)?.closest('.print')?.dataset.card;
  const mark = (target) => element.querySelectorAll('.print').forEach((one) => {
    one.classList.toggle('dragged', key !== null && one.dataset.card === key);
    one.classList.toggle('over', key !== null && one.dataset.card === target && target !== key);
  });
  element.addEventListener('pointerdown', (event) => {
    const target = event.target.closest('.print');
    if (!target || event.button !== 0 || event.target.closest('button') || asked.cards) return;
    key = target.dataset.card;
    element.setPointerCapture(event.pointerId);
    event.preventDefault();
    mark(key);
  });
  element.addEventListener('pointermove', (event) => { if (key !== null) mark(over(event)); });
  const end = (event, done) => {
    if (key === null) return;
    const from = key, target = done ? over(event) : null;
    key = null;
    mark(null);
    if (target && target !== from) drop(from, place(state(), target));
  };
  element.addEventListener('pointerup', (event) => end(event, true));
  element.addEventListener('pointercancel', (event) => end(event, false));
}
