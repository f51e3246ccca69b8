"""The tests that the changes since a revision can break, as a filter for cargo-nextest.

    changed.py [REVISION]

A changed room is proved by its own unit tests, those of all rooms that import it, directly or through others, and the modules of tests/it that
tests/it/rooms.txt says are about it; a changed module of tests/it by itself. Anything else that is compiled or read by many (Cargo.toml, profiles,
fixtures, tests/it/support.rs) is proved by all tests. Nothing is printed where nothing has changed.
"""

import re
import subprocess
import sys
from pathlib import Path


def table(text):
    """The rooms, and by module of tests/it those that it is about."""
    rooms, about = [], {}
    for words in (line.split() for line in text.splitlines()):
        if words and words[0] == "floor":
            rooms += words[1:]
        elif words and words[0] == "test":
            about[words[1]] = set(words[2:])
    return rooms, about


def imports(source, rooms):
    """By room the rooms that its files name, `crate::ROOM`."""
    found = {}
    for room in rooms:
        files = [source / f"{room}.rs", *(source / room).rglob("*.rs")]
        text = "\n".join(file.read_text() for file in files if file.is_file())
        named = set(re.findall(r"\bcrate::(\w+)", text))
        for group in re.findall(r"\bcrate::\{([^;]*)\}", text):
            named |= set(re.findall(r"\w+", group))
        found[room] = named & set(rooms) - {room}
    return found


def above(room, imported):
    """`room` and all that import it, directly or through others."""
    reached = {room}
    while True:
        more = {name for name, named in imported.items() if named & reached} - reached
        if not more:
            return reached
        reached |= more


def tests(paths, rooms, about, imported):
    """The filter for these changed paths; "" for none."""
    units, modules = set(), set()
    for path in paths:
        room = re.match(r"src/(\w+)(?:\.rs|/)", path)
        module = re.match(r"tests/it/(\w+)(?:\.rs|/)", path)
        if room and room[1] in rooms:
            units |= above(room[1], imported)
            modules |= {name for name, proved in about.items() if room[1] in proved}
        elif module and module[1] in about:
            modules.add(module[1])
        elif path.startswith(("docs/", "README")):
            modules |= {"recipes", "readable", "messages", "schemas", "packages", "architecture"}
        elif not path.startswith(("scripts/", ".ci/", "CHANGELOG", "benches/", "fuzz/", "python/", ".config/")):
            return "all()"
    named = [f"(binary(trunnion) & test(/^({'|'.join(sorted(units))})::/))"] if units else []
    named += [f"(binary(it) & test(/^({'|'.join(sorted(modules))})::/))"] if modules else []
    return " | ".join(named)


def main():
    root = Path(__file__).resolve().parent.parent
    revision = sys.argv[1] if len(sys.argv) > 1 else "HEAD"
    git = ["git", "-C", str(root)]
    changed = subprocess.run([*git, "diff", "--name-only", revision], check=True, capture_output=True, text=True).stdout
    new = subprocess.run([*git, "ls-files", "--others", "--exclude-standard"], check=True, capture_output=True, text=True).stdout
    rooms, about = table((root / "tests/it/rooms.txt").read_text())
    print(tests((changed + new).split(), rooms, about, imports(root / "src", rooms)))


main()
