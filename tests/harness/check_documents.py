"""The verdict of Python's jsonschema: check_documents.py SCHEMAS, with a line ["file", document] each on stdin.

A line each on stdout: "valid", or what is wrong. With a folder of kept documents as second argument (FILE.KIND.HASH.json, as the tests
write them where TRUNNION_DOCUMENTS says so) these are checked instead, and every kind of every schema must be among them.
"""

import json
import pathlib
import sys

from jsonschema import Draft202012Validator
from referencing import Registry, Resource

folder = pathlib.Path(sys.argv[1])
schemas = {path.name: json.loads(path.read_text()) for path in folder.glob("*.json")}
registry = Registry().with_resources((name, Resource.from_contents(schema)) for name, schema in schemas.items())
for schema in schemas.values():
    Draft202012Validator.check_schema(schema)
validators = {name: Draft202012Validator(schema, registry=registry) for name, schema in schemas.items()}


def verdict(name, document):
    error = next(iter(validators[name].iter_errors(document)), None)
    return "valid" if error is None else f"{error.json_path}: {error.message[:200]}".replace("\n", " ")


if len(sys.argv) == 2:
    for line in sys.stdin:
        print(verdict(*json.loads(line)))
    sys.exit()

kinds = {}
bad = 0
for path in sorted(pathlib.Path(sys.argv[2]).glob("*.json")):
    name, kind = path.name.split(".")[:2]
    said = verdict(f"{name}.json", json.loads(path.read_text()))
    kinds[name, kind] = kinds.get((name, kind), 0) + 1
    if said != "valid":
        bad += 1
        print(f"{path}: {said}")
for name, schema in schemas.items():
    for one in schema.get("oneOf", []):
        kind = one.get("$ref", "/list").rsplit("/", 1)[-1]
        if (name[:-5], kind) not in kinds:
            bad += 1
            print(f"{name}: no test prints its {kind}")
print(f"{sum(kinds.values())} documents of {len(kinds)} kinds, {bad} complaints")
sys.exit(1 if bad else 0)
