"""The pictures of the README and of the workbench, taken from preview pages and from the workbench itself: python3 scripts/pictures.py [PROGRAM] [FOLDER]

PROGRAM is trunnion (default target/release/trunnion), FOLDER where they go (default docs/pictures). Needs Chromium. The solids are made
here; what is shown is a file that was verified.
"""

import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/trunnion").resolve()
FOLDER = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else ROOT / "docs/pictures").resolve()
SIZE = 640, 480
# The picture alone, in light colours, from nearer.
ALONE = """ready.then(() => {
  for (const e of document.querySelectorAll('body *')) {
    const keeps = e.id === 'canvas' || e.contains(document.getElementById('canvas'));
    if (!keeps) e.style.display = 'none';
  }
  const view = document.getElementById('canvas');
  for (let e = view; e !== document.body; e = e.parentElement) Object.assign(e.style, {position: 'fixed', inset: 0, width: '100vw', height: '100vh'});
  setTheme(false);
})"""


def facets(path, triangles):
    """Binary STL."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *sum(map(list, t), []), 0) for t in triangles)
    path.write_bytes(bytes(80) + struct.pack("<I", len(triangles)) + body)


def extruded(outline, convex, depth):
    """A prism; `convex` are pieces of the outline that together fill it."""
    out = []
    for piece in convex:
        for i in range(1, len(piece) - 1):
            a, b, c = piece[0], piece[i], piece[i + 1]
            out.append([(p[0], 0.0, p[1]) for p in (a, b, c)])
            out.append([(p[0], depth, p[1]) for p in (a, c, b)])
    for a, b in zip(outline, outline[1:] + outline[:1]):
        p, q, r, s = (a[0], 0.0, a[1]), (b[0], 0.0, b[1]), (b[0], depth, b[1]), (a[0], depth, a[1])
        out += [[p, r, q], [p, s, r]]
    return out


def turned(profile, sides):
    """A solid of revolution; the profile goes from the axis up to the axis."""
    out = []
    at = lambda p, k: (p[0] * math.cos(math.tau * k / sides), p[0] * math.sin(math.tau * k / sides), p[1])
    for a, b in zip(profile, profile[1:]):
        for k in range(sides):
            p, q, r, s = at(a, k), at(a, (k + 1) % sides), at(b, (k + 1) % sides), at(b, k)
            if a[0] > 0:
                out.append([p, q, r])
            if b[0] > 0:
                out.append([p, r, s])
    return out


def tee(path):
    # Every corner of a piece is one of the outline, so that the surface is closed.
    outline = [(-8, 0), (8, 0), (8, 40), (35, 40), (35, 52), (8, 52), (-8, 52), (-35, 52), (-35, 40), (-8, 40)]
    middle, left, right = [(-8, 40), (8, 40), (8, 52), (-8, 52)], [(-35, 40), (-8, 40), (-8, 52), (-35, 52)], [(8, 40), (35, 40), (35, 52), (8, 52)]
    facets(path, extruded(outline, [[(-8, 0), (8, 0), (8, 40), (-8, 40)], middle, left, right], 16.0))


def mushroom(path):
    cap = [(30 * math.cos(a), 40 + 15 * math.sin(a)) for a in (math.pi / 2 * k / 16 for k in range(16))]
    facets(path, turned([(0, 0), (10, 0), (10, 40)] + cap + [(0, 55)], 64))


def run(folder, *args):
    subprocess.run([PROGRAM, *args], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def shot(folder, page, picture, *steps):
    """A picture of the page after some steps (JavaScript)."""
    wait = "new Promise((done) => setTimeout(done, 8000))"
    orders = [{"eval": ALONE}, *({"eval": step} for step in steps), {"eval": wait}, {"shot": str(FOLDER / picture)}]
    driver = [sys.executable, ROOT / "tests/it/preview/chromium.py", "chromium", folder / page, *map(str, SIZE)]
    subprocess.run(driver, input=json.dumps(orders).encode(), check=True, stdout=subprocess.DEVNULL)


def chunks(path):
    data, at = path.read_bytes(), 8
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        yield kind, data[at + 8 : at + 8 + size]
        at += 12 + size


def rows(path):
    """Width, height and the rows of a PNG of 8 bits, red, green and blue alone."""
    head, body = None, b""
    for kind, data in chunks(path):
        head = data if kind == b"IHDR" else head
        body += data if kind == b"IDAT" else b""
    width, height, depth, colours = struct.unpack(">IIBB", head[:10])
    each = {2: 3, 6: 4}[colours]
    assert depth == 8
    raw, last, out = zlib.decompress(body), bytes(width * each), []
    for y in range(height):
        start = y * (width * each + 1)
        kind, row = raw[start], bytearray(raw[start + 1 : start + 1 + width * each])
        for i in range(len(row)):
            a = row[i - each] if i >= each else 0
            b, c = last[i], last[i - each] if i >= each else 0
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[i] = (row[i] + (0, a, b, (a + b) // 2, nearest)[kind]) & 255
        last = bytes(row)
        out.append(b"".join(last[i : i + 3] for i in range(0, len(last), each)))
    return width, height, out


def coarse(row):
    """Sixteen steps a colour: what a small moving picture needs."""
    return bytes((v & 0xF0) | (v >> 4) for v in row)


def animated(frames, path, milliseconds):
    """An animated PNG (https://www.w3.org/TR/png-3/) of pictures of one size; rows are packed as differences from the one above."""
    out, number = b"\x89PNG\r\n\x1a\n", 0

    def put(kind, data):
        nonlocal out
        out += struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    for k, frame in enumerate(frames):
        width, height, lines = rows(frame)
        if k == 0:
            put(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            put(b"acTL", struct.pack(">II", len(frames), 0))
        put(b"fcTL", struct.pack(">IIIIIHHBB", number, width, height, 0, 0, milliseconds, 1000, 0, 0))
        number += 1
        packed, last = b"", bytes(width * 3)
        for line in map(coarse, lines):
            packed += b"\2" + bytes((a - b) & 255 for a, b in zip(line, last))
            last = line
        data = zlib.compress(packed, 9)
        if k == 0:
            put(b"IDAT", data)
        else:
            put(b"fdAT", struct.pack(">I", number) + data)
            number += 1
    put(b"IEND", b"")
    path.write_bytes(out)


# More beads than a moving camera has, fewer than all.
MORE = "few = beads.few(60000); stuff.few = drawing.beadSet(few.points, few.sizes, new Uint8Array(few.of.length * 4), 2); recolour()"
# The quick picture of what is shown now: the whole one takes software some seconds, and a small frame shows no more of it.
QUICK = "new Promise((done) => { [state.slow, state.late] = [false, -1e9]; const last = state.frames; invalidate(); const look = () => (state.frames > last ? done(0) : setTimeout(look, 10)); look(); })"


def film(folder, page, picture, count):
    """The print from its beginning to its end on the turning table, frames of the page."""
    orders = [{"eval": ALONE}, {"eval": "setView(false); camera.distance *= 0.8; grow = async () => {}; state.mode = 'part'"}, {"eval": MORE}]
    for k in range(count):
        # As much is laid from frame to frame; the last ones show it done.
        orders.append({"eval": f"seek(Math.floor((replay.count - 1) * Math.min(1, {(k + 1) / (count - 3)})))"})
        orders += [{"eval": QUICK}, {"shot": str(folder / f"frame-{k:03}.png")}]
    driver = [sys.executable, ROOT / "tests/it/preview/chromium.py", "chromium", folder / page, "420", "330"]
    subprocess.run(driver, input=json.dumps(orders).encode(), check=True, stdout=subprocess.DEVNULL)
    animated([folder / f"frame-{k:03}.png" for k in range(count)], FOLDER / picture, 220)


def workbench(folder, picture):
    """The room of ways, with a model whose ways are found."""
    args = ["open", "hook.stl", "-m", "generic-ac", "--no-browser", "--json"]
    server = subprocess.Popen([PROGRAM, *args], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        address = json.loads(server.stdout.readline())["address"]
        ready = "workbench.scene.order.length && !workbench.scene.waiting && workbench.page.machines.machines"
        done = "workbench.page.state.ways && !workbench.page.state.busy"
        orders = [{"until": ready}, {"click": "#room-how"}, {"click": "#find"}, {"until": done}, {"shot": str(FOLDER / picture)}]
        driver = [sys.executable, ROOT / "tests/it/preview/chromium.py", "chromium", address, "1200", "740"]
        subprocess.run(driver, input=json.dumps(orders).encode(), check=True, stdout=subprocess.DEVNULL)
    finally:
        server.terminate()
        server.wait()


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        tee(folder / "tee.stl")
        mushroom(folder / "mushroom.stl")
        (folder / "candelabrum.stl").write_bytes((ROOT / "fixtures/candelabrum.stl").read_bytes())
        machine = ["-m", "generic-ac", "--slicer", "builtin"]
        run(folder, "prepare", "tee.stl", *machine, "-o", "tee.gcode", "--preview", "tee.html")
        run(folder, "prepare", "mushroom.stl", *machine, "--split", "never", "-o", "mushroom.gcode", "--preview", "mushroom.html")
        run(folder, "prepare", "candelabrum.stl", *machine, "-o", "candelabrum.gcode", "--preview", "candelabrum.html")
        # The page shows the name of the project's folder.
        project = folder / "hook"
        project.mkdir()
        (project / "hook.stl").write_bytes((ROOT / "fixtures/hook.stl").read_bytes())
        workbench(project, "workbench.png")
        near = "camera.distance *= 0.62; invalidate()"
        feature = "state.mode = 'feature'; recolour()"
        shot(folder, "tee.html", "tee-in-parts.png", "state.table = false; invalidate()", near)
        shot(folder, "mushroom.html", "mushroom-on-supports.png", feature, near)
        shot(folder, "candelabrum.html", "candelabrum-tilted.png", "seek(Math.floor(replay.count * 0.62))", "state.table = false; invalidate()")
        film(folder, "candelabrum.html", "candelabrum.png", 24)


main()
