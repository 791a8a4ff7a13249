"""Files of runs and studies: read within bounds, with errors that name the file; written whole."""

import contextlib
import json
import math
import os
import secrets
import tomllib

import numpy as np

from mpmtools.errors import ConfigError, InputError

MOST_BYTES = 1 << 28  # a table takes several times as much memory


class MissingEntry(InputError, KeyError):
    """An entry that a file lacks."""

    __str__ = Exception.__str__


class Entries(dict):
    """A table of a file. An entry that it lacks is a MissingEntry, which names the file."""

    path = "a file"

    def __missing__(self, key):
        raise MissingEntry(f"{self.path}: there is no entry '{key}'; the file is damaged, or of another program")


def _entries(value, path):
    if isinstance(value, list):
        return [_entries(item, path) for item in value]
    if not isinstance(value, dict):
        return value
    table = Entries({key: _entries(item, path) for key, item in value.items()})
    table.path = path
    return table


def read_text(path):
    """The content of a text file in UTF-8, behind a byte-order mark if there is one."""
    try:
        with open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise InputError(f"cannot read '{path}': it has more than {MOST_BYTES} bytes; this is no file of this program")
        return content.decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read '{path}': {error.strerror}") from None
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}:{line}: a character is not UTF-8; save the file with that encoding") from None


def read_json(path, remedy="compute it again"):
    """The object in a JSON file, as Entries."""
    text = read_text(path)
    try:
        content = _entries(json.loads(text), path)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: it is not JSON: {error}; {remedy}") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: it holds no JSON object; {remedy}")
    return content


def plain(value):
    """Python's own types, for JSON; numbers that are none, or infinite, become None."""
    if isinstance(value, dict):
        return {key: plain(v) for key, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def read_toml(path):
    """The tables of a TOML file, as Entries."""
    text = read_text(path).replace("\r\n", "\n")
    try:
        return _entries(tomllib.loads(text), path)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{path}: {error}") from None


def require_no_files(folder, names):
    """ConfigError if a folder holds files of these names, which would be overwritten."""
    if found := [name for name in names if os.path.lexists(os.path.join(folder, name))]:
        raise ConfigError(f"{folder} holds {', '.join(found)}; choose another folder with --out, or overwrite with --force")


def require_ending(path, *endings):
    """ConfigError for the name of a file to write that does not end as such files do. So --out can replace an earlier picture or page, but no
    case, table or result."""
    if not str(path).lower().endswith(endings):
        raise ConfigError(f"--out {path}: the name has to end with {' or '.join(endings)}")


@contextlib.contextmanager
def whole_file(path):
    """The path of a temporary file, which becomes `path` if nothing fails. Nobody can have put a link at its name."""
    folder, name = os.path.split(os.path.abspath(path))
    temporary = os.path.join(folder, f".{secrets.token_hex(8)}.{name}")
    try:
        os.makedirs(folder, exist_ok=True)
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(f"cannot write '{path}': {error.strerror or error}") from None
    finally:
        with contextlib.suppress(OSError):
            os.unlink(temporary)


def save_figure(figure, path, **options):
    """Writes a matplotlib figure whole and closes it."""
    from matplotlib import pyplot

    try:
        with whole_file(path) as temporary:
            figure.savefig(temporary, **options)
    finally:
        pyplot.close(figure)


def write_text(path, text):
    """Writes a file whole: under a temporary name, then renamed."""
    with whole_file(path) as temporary, open(temporary, "w", encoding="utf-8") as file:
        file.write(text)
