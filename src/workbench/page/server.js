// The way to the server. The secret is in the fragment of the page's address, which browsers send to nobody; the page sends it as a header.

const secret = location.hash.slice(1);
const headers = { Authorization: `Bearer ${secret}` };

export const hasSecret = secret !== '';

/** A failure as the server and the command tell it: a sentence and a code. */
export class Refusal extends Error {
  constructor({ error, code }) {
    super(error);
    this.code = code;
  }
}

const address = (path, query) => `/api/${path}?${new URLSearchParams(query)}`;

async function answer(response) {
  const document = await response.json();
  if (!response.ok) throw new Refusal(document);
  return document;
}

/** Asks for a document. */
export async function get(path, query = {}) {
  return answer(await fetch(address(path, query), { headers }));
}

/** Has something done; the answer is the new state. */
export async function post(path, query = {}, body = undefined) {
  return answer(await fetch(address(path, query), { method: 'POST', headers, body }));
}

/** The block of a model of the project as the page has seen it: the document at its head, and the two columns behind it. */
export async function block(index, revision) {
  const response = await fetch(address('model', { index, revision }), { headers });
  if (!response.ok || response.headers.get('Content-Type') === 'application/json') throw new Refusal(await response.json());
  const bytes = new Uint8Array(await response.arrayBuffer()), view = new DataView(bytes.buffer), sections = [];
  for (let at = 0; at < bytes.length;) {
    const length = view.getUint32(at, true);
    sections.push(bytes.subarray(at + 4, at + 4 + length));
    at += 4 + length;
  }
  return { ...JSON.parse(new TextDecoder().decode(sections[0])), columns: sections.slice(1) };
}

/** Hears the state whenever it changes, and connects again when the server has gone; `ended` says that it will not come back. */
export async function listen(hear, lost, ended) {
  for (;;) {
    try {
      await post('session');
      const response = await fetch('/api/events', { headers });
      const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
      for (let text = ''; ;) {
        const { value, done } = await reader.read();
        if (done) break;
        const events = (text + value).split('\n\n');
        text = events.pop();
        const last = events.filter((event) => event.startsWith('data: ')).pop();
        if (last) hear(JSON.parse(last.slice(6)));
      }
    } catch (error) {
      if (error instanceof Refusal) return lost(error.message);
    }
    if (ended()) return undefined;
    lost(null);
    await new Promise((done) => setTimeout(done, 700));
  }
}
