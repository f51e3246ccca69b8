#!/usr/bin/env python3
"""The bill of materials of what is built from Cargo.lock, as CycloneDX 1.5 JSON: every package with version, hash, licence and what it needs.

    sbom.py [-o FILE]      writes it (to stdout); the same commit gives the same bytes
    sbom.py --check FILE   compares FILE with Cargo.lock: exit code 1 where a package is missing, added, or of another version or hash

`scope` says where a package ends up: `required` in every build of the command, `optional` only with a feature or on another system than Linux,
`excluded` in none (tests, builds, the Python package's own). Facts are cargo's, which may fetch packages of other systems; the comparison reads
Cargo.lock by itself.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys
import uuid

ROOT = pathlib.Path(__file__).resolve().parent.parent
ITSELF = "trunnion"


def locked(path):
    """Packages of a Cargo.lock: (name, version) to the checksum; none for those of this repository."""
    packages = {}
    for block in path.read_text(encoding="utf-8").split("[[package]]")[1:]:
        facts = dict(re.findall(r'^(name|version|checksum) = "([^"]*)"$', block, re.MULTILINE))
        packages[facts["name"], facts["version"]] = facts.get("checksum")
    return packages


def cargo(*words):
    return subprocess.run(["cargo", *words, "--locked"], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def linked(*words):
    """(name, version) of what the command is linked from, built like this; macros that it is compiled with among them."""
    text = cargo("tree", "--package", ITSELF, "--edges", "normal", "--prefix", "none", "--format", "{p}", *words)
    return {tuple(line.split()[:2]) for line in text.splitlines() if line}


def reference(package):
    return f"pkg:cargo/{package['name']}@{package['version']}"


def component(package, checksum, scope):
    made = {
        "type": "library",
        "bom-ref": reference(package),
        "name": package["name"],
        "version": package["version"],
        "scope": scope,
        "purl": reference(package),
    }
    if checksum:
        made["hashes"] = [{"alg": "SHA-256", "content": checksum}]
    if package["license"]:
        # Old packages write MIT/Apache-2.0 for either.
        made["licenses"] = [{"expression": package["license"].replace("/", " OR ")}]
    if package["repository"]:
        made["externalReferences"] = [{"type": "vcs", "url": package["repository"]}]
    return made


def made():
    lock = locked(ROOT / "Cargo.lock")
    whole = json.loads(cargo("metadata", "--format-version", "1", "--all-features"))
    plain = linked("--target", "x86_64-unknown-linux-gnu")
    every = linked("--target", "all", "--all-features")
    by_id = {package["id"]: package for package in whole["packages"]}
    components, itself = [], None
    for package in whole["packages"]:
        spelt = (package["name"], "v" + package["version"])
        scope = "required" if spelt in plain else "optional" if spelt in every else "excluded"
        one = component(package, lock.get((package["name"], package["version"])), scope)
        if package["name"] == ITSELF and package["source"] is None:
            itself = {**one, "type": "application"}
        else:
            components.append(one)
    needs = {
        reference(by_id[node["id"]]): sorted({reference(by_id[dependency["pkg"]]) for dependency in node["deps"]})
        for node in whole["resolve"]["nodes"]
    }
    document = {
        "$schema": "http://cyclonedx.org/schema/bom-1.5.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": itself, "tools": {"components": [{"type": "application", "name": "scripts/sbom.py"}]}},
        "components": sorted(components, key=lambda one: one["bom-ref"]),
        "dependencies": [{"ref": one, "dependsOn": needs[one]} for one in sorted(needs)],
    }
    # Of the content, so that the same commit has the same number, and no other has it.
    name = json.dumps(document, sort_keys=True)
    document["serialNumber"] = f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, name)}"
    return json.dumps(document, indent=1) + "\n"


def differences(path, lock):
    """What is not as it is locked, a sentence each."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        all_of_it = [document["metadata"]["component"], *document["components"]]
        hashed = {
            (one["name"], one["version"]): next((h["content"] for h in one.get("hashes", [])), None) for one in all_of_it
        }
    except (OSError, ValueError, KeyError, TypeError) as error:
        return [f"{path}: not a bill of materials: {error!r}"]
    said = [f"{path}: {name} {version} is missing" for name, version in sorted(lock.keys() - hashed.keys())]
    said += [f"{path}: {name} {version} is not in Cargo.lock" for name, version in sorted(hashed.keys() - lock.keys())]
    both = sorted(lock.keys() & hashed.keys())
    said += [f"{path}: {name} {version} has another hash" for name, version in both if lock[name, version] != hashed[name, version]]
    if len(all_of_it) != len(hashed):
        said.append(f"{path}: a package is there twice")
    return said


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=pathlib.Path)
    parser.add_argument("--check", type=pathlib.Path, metavar="FILE")
    parser.add_argument("--lock", type=pathlib.Path, default=ROOT / "Cargo.lock", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.check:
        said = differences(given.check, locked(given.lock))
        print("\n".join(said) or f"{given.check}: as in Cargo.lock")
        return 1 if said else 0
    text = made()
    if given.output:
        given.output.write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
