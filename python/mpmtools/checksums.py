"""Files of a run, read only if they match their checksums: what a run wrote is what is evaluated."""

import functools
import os
import re
import zlib

from mpmtools.errors import InputError
from mpmtools.files import read_json, read_text
from mpmtools.tables import read_series

REMEDY = "`mpm run --resume` writes it again"
SEAL = b"MPMCRC32"  # and eight digits: the end of every HDF5 file of libmpm
ENTRY = re.compile(rb'(?<="crc32": ")[0-9a-f]{8}(?=")')  # of results.json: its own checksum, computed with zeros in its place


def checksum(data):
    """CRC-32 of bytes as eight hexadecimal digits."""
    return f"{zlib.crc32(data):08x}"


def check_seal(path):
    """InputError if an HDF5 file of libmpm does not match its checksum."""
    status = os.stat(path)
    _check_seal(str(path), status.st_mtime_ns, status.st_size)


@functools.lru_cache(maxsize=1024)
def _check_seal(path, _changed, size):
    """Reads the file once, in pieces, for as long as it does not change."""
    crc, rest = 0, size - len(SEAL) - 8
    with open(path, "rb") as file:
        while rest > 0 and (piece := file.read(min(rest, 1 << 20))):
            crc, rest = zlib.crc32(piece, crc), rest - len(piece)
        end = file.read()
    if not end.startswith(SEAL):
        raise InputError(f"cannot read '{path}': it does not end as files of libmpm do; it was cut off, or another program wrote it")
    if end != SEAL + b"%08x" % crc:
        raise InputError(f"cannot read '{path}': it does not match its checksum; it was altered or damaged")


def read_results(path, remedy=REMEDY):
    """results.json, or another file with such a checksum, as a dict. InputError if it does not match; without one, an older version wrote it."""
    content, results = read_text(path).encode(), read_json(path, remedy)
    found = ENTRY.search(content)
    right = found and checksum(content[:found.start()] + b"0" * 8 + content[found.end():]) == found[0].decode()
    if not right and b"crc32" in content:
        raise InputError(f"{path}: it does not match its checksum; {remedy}")
    return results


def read_table_of(path):
    """series.csv or profile.csv of a run. InputError if it does not match its checksum in the results.json beside it."""
    folder, name = os.path.split(path)
    results = os.path.join(folder, "results.json")
    expected = read_results(results).get(name.replace(".csv", "_crc32")) if os.path.exists(results) else None
    if expected is not None:
        with open(path, "rb") as file:
            if checksum(file.read()) != expected:
                raise InputError(f"{path}: it does not match its checksum in results.json; {REMEDY}")
    return read_series(path)
