"""TOML as text: the part of the format that case files and plans use. Python's tomllib only reads."""

import json
import math
import re

from mpmtools.errors import ConfigError

BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(tables):
    """A dict as TOML. Values are text, numbers, true and false, lists, dicts (tables) and lists of dicts (arrays of tables); arrays and numbers of
    numpy are written as lists and numbers."""
    return "\n".join(_lines(tables, ())).strip() + "\n"


def with_lists(value):
    """The value with lists in place of numpy's arrays, also inside dicts and lists, which are changed."""
    if isinstance(value, (dict, list)):
        for key, entry in value.items() if isinstance(value, dict) else enumerate(value):
            value[key] = with_lists(entry)
        return value
    return value.tolist() if hasattr(value, "tolist") else value


def _lines(table, path):
    """Plain keys first: behind the header of a table they would belong to that table."""
    nested = {key: value for key, value in table.items() if isinstance(value, dict) or _is_array_of_tables(value)}
    for key, value in table.items():
        if key not in nested:
            yield f"{_key(key)} = {_value(value, (*path, key))}"
    for key, value in nested.items():
        name = ".".join(map(_key, (*path, key)))
        for entry in [value] if isinstance(value, dict) else value:
            yield ""
            yield f"[{name}]" if isinstance(value, dict) else f"[[{name}]]"
            yield from _lines(entry, (*path, key))


def _is_array_of_tables(value):
    return isinstance(value, list) and bool(value) and all(isinstance(entry, dict) for entry in value)


def _key(name):
    return name if BARE_KEY.fullmatch(name) else json.dumps(name)


def _value(value, path):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(entry, path) for entry in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(key)} = {_value(entry, path)}" for key, entry in value.items()) + "}"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if math.isfinite(value):
            return repr(float(value))
        return "nan" if math.isnan(value) else "inf" if value > 0.0 else "-inf"
    if hasattr(value, "tolist"):  # numpy's arrays, and its numbers other than float64
        return _value(value.tolist(), path)
    raise ConfigError(f"{'.'.join(map(str, path))} = {value!r}: a case holds text, numbers, true and false, lists and tables")
