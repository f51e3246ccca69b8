// The room of ways: what each costs, side by side, and which one is chosen.

import { button, choice, failure, figures, h, notice, number, time } from './parts.js';
import { cutsPanel } from './cuts.js';
import { orderLine } from './order.js';
import { log, progress } from './see.js';
import { TEXTS } from './texts.js';

/** A way that could be printed but is not worth it has a price; one that cannot has none. */
const kind = (way) => (way.why_not === null ? 'possible' : way.price_min === null ? 'impossible' : 'dearer');

function wayCard(way, state, cheapest, prepared) {
  const what = kind(way), forced = state.way === way.way, made = way.way === prepared;
  const badges = [
    way === cheapest && h('span', { class: 'badge good', text: TEXTS.cheapest }),
    made && h('span', { class: 'badge', text: TEXTS.made }),
    what === 'dearer' && h('span', { class: 'badge', text: TEXTS.dearer }),
    what === 'impossible' && h('span', { class: 'badge bad', text: TEXTS.notPossible }),
  ];
  const rows = what === 'possible' && [
    [TEXTS.printTime, time(way.minutes * 60)],
    [TEXTS.filament, `${number(way.grams)} g`],
    [TEXTS.supportMass, `${number(way.support_g)} g`],
    [TEXTS.seams, `${number(way.seam_mm2, 0)} mm²`],
    [TEXTS.setups, number(way.setups, 0)],
    [TEXTS.stands, way.stands === null ? '–' : `${number(way.stands)}×`, TEXTS.standsHint],
  ];
  return h(
    'button',
    { id: `way-${way.way}`, type: 'button', class: `way ${what}${forced ? ' forced' : ''}`, 'data-do': 'way', 'data-way': way.way, 'aria-pressed': String(forced) },
    h('span', { class: 'badges' }, badges),
    h('strong', { text: TEXTS.ways[way.way] ?? way.way }),
    h('span', { class: 'soft', text: TEXTS.wayHints[way.way] }),
    way.price_min !== null && h('span', { class: 'price', title: TEXTS.priceTitle }, number(way.price_min), h('small', { text: ` ${TEXTS.priceUnit}` })),
    rows && figures(rows),
    way.why_not !== null && h('span', { class: 'why', text: way.why_not }),
  );
}

/** The cards, cheapest first; the first one leaves the choice to the price. */
export function deck(state) {
  const { ways, stale } = state.ways ?? { ways: [], stale: false };
  if (!ways.length) return [h('div', { class: 'no-ways' }, h('strong', { text: TEXTS.noWays }), h('p', { class: 'soft', text: TEXTS.noWaysHint }))];
  const made = state.prepared && !state.prepared.stale && (state.prepared.document.ways ?? []).find((way) => way.chosen)?.way;
  const rank = (way) => ({ possible: 0, dearer: 1, impossible: 2 })[kind(way)] * 1e9 + (way.price_min ?? 0);
  const sorted = [...ways].sort((a, b) => rank(a) - rank(b)), cheapest = sorted.find((way) => kind(way) === 'possible');
  const auto = h(
    'button',
    { id: 'way-auto', type: 'button', class: `auto${state.way === 'auto' ? ' forced' : ''}`, 'data-do': 'way', 'data-way': 'auto', 'aria-pressed': String(state.way === 'auto') },
    h('strong', { text: TEXTS.auto }), cheapest && h('span', { class: 'soft', text: TEXTS.autoNow(TEXTS.ways[cheapest.way] ?? cheapest.way) }),
  );
  return [auto, h('div', { class: `ways${stale ? ' stale' : ''}` }, sorted.map((way) => wayCard(way, state, cheapest, made))), h('section', { id: 'order' }, orderLine(state))];
}

export function howPanel(state, picking) {
  const run = state.runs.prepare, { why_not: missing } = state.commands.prepare, { ways, prepared } = state;
  const done = prepared && !prepared.stale && prepared.document.verify, old = ways && !ways.stale && prepared?.stale;
  const what = old ? TEXTS.prepareThis : ways ? TEXTS.findAgain : TEXTS.findWays;
  return [
    h('h2', { text: TEXTS.howTitle }),
    h('p', { class: 'soft', text: TEXTS.howHint }),
    missing && notice('note', TEXTS.notYet(missing)),
    run?.running ? progress(run, 'prepare') : button('find', what, { id: 'find', class: done ? null : 'primary', disabled: Boolean(missing) || state.busy }),
    done && !run?.running && button('room', TEXTS.seeIt, { id: 'see-it', class: 'primary', 'data-room': 'see' }),
    ways?.stale && notice('stale', TEXTS.stale, TEXTS.staleWays),
    choice('finish', TEXTS.finish, state.finish, state.choices.finish.map((one) => [one, TEXTS.finishes[one]])),
    choice('slicer', TEXTS.slicer, state.slicer, state.choices.slicer.map((one) => [one, one === 'auto' ? TEXTS.slicerAuto : one])),
    run?.failed && !state.prepared?.stale && failure(run.failed, TEXTS.code),
    ...cutsPanel(state, picking),
    log(run),
  ];
}
