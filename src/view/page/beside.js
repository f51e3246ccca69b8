// Two pages side by side in one: what the camera does in one of them it does in the other, and so does the choice of view.
//
// Each is a frame of the page around both and hears the other by messages. What comes from elsewhere is no numbers, or numbers for a
// camera, and nothing else is done with it. The page around them may name a line of the program, which is then shown.

const beside = { on: window.parent !== window, told: '', others: () => [...Array(window.parent.length).keys()].map((i) => window.parent[i]).filter((other) => other !== window) };

/** Tells the other page where the camera is, if that has changed. */
function tellBeside() {
  if (!beside.on) return;
  const said = JSON.stringify({ camera: { yaw: camera.yaw, pitch: camera.pitch, distance: camera.distance, target: [...camera.target] }, table: state.table });
  if (said === beside.told) return;
  beside.told = said;
  beside.others().forEach((other) => other.postMessage(said, '*'));
}

function hearBeside(event) {
  if (!beside.on || typeof event.data !== 'string') return;
  if (event.source === window.parent) return hearAround(event.data);
  if (!beside.others().includes(event.source)) return;
  const { camera: heard, table } = JSON.parse(event.data), number = (v) => typeof v === 'number' && Number.isFinite(v);
  if (![heard.yaw, heard.pitch, heard.distance, ...heard.target].every(number) || heard.target.length !== 3) return;
  Object.assign(camera, { yaw: heard.yaw, pitch: heard.pitch, distance: heard.distance, target: heard.target });
  beside.told = event.data;
  if (table !== state.table) setView(table === true, false);
  else invalidate();
}

/** The page around this one, which prints what is shown here or lists its findings, names a line. */
function hearAround(text) {
  let line = null;
  try {
    ({ line } = JSON.parse(text));
  } catch {
    return;
  }
  if (replay && Number.isInteger(line) && line > 0) seekLine(line);
}
