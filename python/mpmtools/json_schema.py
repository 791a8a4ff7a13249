"""The JSON Schema of case files, for editors: keys, units, ranges and meanings while one types (Even Better TOML, Taplo, ...).

It follows from `mpm schema --json`. What a schema says: names, types, ranges, words, and what is required. What it leaves to `mpm check`:
keys that hold only under a condition, and checks between keys.
"""

import contextlib
import copy
import json

from mpmtools.errors import MpmError
from mpmtools.files import write_text
from mpmtools.program import run_program

NUMBER = {"type": "number"}
TYPES = {  # as `mpm schema` names them
    "string": {"type": "string"},
    "integer": {"type": "integer"},
    "number": NUMBER,
    "true or false": {"type": "boolean"},
    "[x, y, z]": {"type": "array", "items": NUMBER, "minItems": 3, "maxItems": 3},
    "list of strings": {"type": "array", "items": {"type": "string"}},
}


def case_schema(reference=None):
    """The schema of a case file as a dict (draft 7). reference: what `mpm schema --json` prints, as a dict; default: from the program."""
    reference = reference or json.loads(run_program("schema", "--json")[1])
    root = _table({"description": "A case of libmpm", "keys": []})
    for table in reference["tables"]:
        if table["in_case"]:
            _place(root, table)
    return {"$schema": "http://json-schema.org/draft-07/schema#", "title": "Case file of libmpm", **root}


def _place(root, table):
    """Puts the schema of a table where its dotted name says: conveyor.inflow is in the properties of conveyor."""
    made = _table(table)
    if not table["name"]:
        root["properties"].update(made["properties"])
        return
    *path, last = table["name"].split(".")
    parent = root
    for name in path:
        parent = parent["properties"][name]
        parent = parent.get("items", parent)
    if not table["repeated"] and not table["optional"] and "required" in made:  # a key without which no case is one: so is its table
        parent.setdefault("required", []).append(last)
    place = {"type": "array", "description": table["description"], "items": made} if table["repeated"] else made
    parent["properties"].setdefault(last, place)


def _table(table):
    schema = {"type": "object", "description": table["description"], "additionalProperties": False,
              "properties": {key["name"]: _key(key) for key in table["keys"]}}
    required = [key["name"] for key in table["keys"] if key.get("required") == "always"]
    return {**schema, "required": required} if required else schema


def _key(key):
    text = key["description"] + (f" ({key['unit']})" if key["unit"] else "") + (f". Only with {key['only_with']}" if key.get("only_with") else "")
    if key["type"] not in TYPES:
        raise MpmError(f"{key['name']}: a key of the type '{key['type']}' has no place in the schema; add it to json_schema.TYPES")
    schema = {"description": text, **copy.deepcopy(TYPES[key["type"]])}
    inner = schema.get("items", schema)
    if "one_of" in key:
        inner["enum"] = [int(word) if key["type"] == "integer" else word for word in key["one_of"]]
    if limits := key.get("range"):
        for bound, name in (("low", "minimum"), ("high", "maximum")):
            inner["exclusive" + name.capitalize() if limits[f"{bound}_open"] else name] = limits[bound]
    with contextlib.suppress(ValueError):  # the program says some defaults in words
        if (value := json.loads(key.get("default", ""))) is not None:
            schema["default"] = value
    return schema


def run_command(options):
    text = json.dumps(case_schema(), indent=2) + "\n"
    if options.out:
        write_text(options.out, text)
    else:
        print(text, end="")
