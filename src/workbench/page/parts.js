// Small parts of the page: elements out of values, and a page that keeps its elements while values change, so that focus and clicks stay.

import { TEXTS } from './texts.js';

/** An element: attributes by name (`text` is its text), then children; what is null or false is left out. */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name === 'text') element.textContent = value;
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** Makes the children of `parent` like `wanted`, and keeps the elements that are alike. */
export function morph(parent, ...wanted) {
  const nodes = wanted.flat(Infinity).filter((node) => node instanceof Node);
  const old = [...parent.childNodes];
  nodes.forEach((node, i) => {
    const before = old[i];
    if (!before) parent.append(node);
    else if (!alike(before, node)) before.replaceWith(node);
    else adopt(before, node);
  });
  old.slice(nodes.length).forEach((node) => node.remove());
}

const alike = (a, b) => a.nodeType === b.nodeType && a.nodeName === b.nodeName && (a.id ?? '') === (b.id ?? '');

function adopt(element, wanted) {
  if (element.nodeType === Node.TEXT_NODE) {
    if (element.data !== wanted.data) element.data = wanted.data;
    return;
  }
  for (const { name } of [...element.attributes]) if (!wanted.hasAttribute(name) && name !== 'open') element.removeAttribute(name);
  for (const { name, value } of wanted.attributes) if (element.getAttribute(name) !== value) element.setAttribute(name, value);
  // What somebody types or chooses now stays until it is sent.
  const typing = element === document.activeElement;
  if (element.nodeName === 'INPUT' && !typing) element.value = wanted.getAttribute('value') ?? '';
  morph(element, ...wanted.childNodes);
  if (element.nodeName === 'SELECT' && !typing) element.value = wanted.value;
}

/** A list of choices; `options` are pairs of value and text, or groups of them by name. */
export function choice(id, label, value, options, attributes = {}) {
  const option = ([one, text]) => h('option', { value: one, text, selected: one === value });
  const all = options.map((entry) => (entry.group ? h('optgroup', { label: entry.group }, entry.options.map(option)) : option(entry)));
  const select = h('select', { id, 'data-set': id, ...attributes }, all);
  select.value = value ?? '';
  return h('label', { class: 'field', for: id }, h('span', { text: label }), select);
}

/** Names and figures. */
export function figures(rows) {
  const row = ([name, value, title]) => h('div', { title }, h('dt', { text: name }), h('dd', { text: value }));
  return h('dl', { class: 'figures' }, rows.filter(Boolean).map(row));
}

/** Something to know, of a kind: note, warn, bad, good, stale. */
export function notice(kind, title, text = null, ...more) {
  return h('div', { class: `notice ${kind}`, role: kind === 'bad' ? 'alert' : null }, h('strong', { text: title }), text && h('p', { text }), more);
}

/** A failure with its sentence, and the command that explains its code; what somebody has stopped is none. */
export function failure(document, code) {
  if (document.code === 'command/interrupted') return notice('note', TEXTS.stopped, TEXTS.stoppedHint);
  return notice('bad', document.error, null, document.code && h('p', {}, h('code', { text: code(document.code) })));
}

export const button = (action, text, attributes = {}) => h('button', { 'data-do': action, text, type: 'button', ...attributes });

/** Minutes or seconds as people say them. */
export function time(seconds) {
  const minutes = Math.round(seconds / 60);
  if (seconds < 60) return `${Math.round(seconds)} s`;
  return minutes < 60 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, '0')} min`;
}

/** A number with so many digits behind the point; a dash where it is unknown. */
export const number = (value, digits = 1) => (typeof value === 'number' ? value.toFixed(digits) : '–');
