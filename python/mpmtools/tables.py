"""CSV tables: strict reading with file and line in every message, shortest numbers in writing."""

import csv
import difflib
import io

import numpy as np
import pandas as pd

from mpmtools.errors import InputError
from mpmtools.files import read_text
from mpmtools.wording import counted


def read_table(path):
    """A table as text, one row of the file a row; comments (#) and empty lines are skipped.

    The index holds the line numbers, `attrs["path"]` the path and `attrs["comments"]` the comment lines without their '#'.
    Numbers are made by `numbers()`, which can then name the line of a cell that is none.
    """
    comments, lines = [], []
    for number, line in enumerate(read_text(path).splitlines(), 1):
        if line.lstrip().startswith("#"):
            comments.append(line.lstrip()[1:].strip())
        elif line.strip():
            lines.append((number, line))
    if not lines:
        raise InputError(f"{path}: no header line; the file is empty or was cut off")
    (first, header), *rows = [(number, _cells(path, number, line)) for number, line in lines]
    for i, name in enumerate(header):
        if not name:
            raise InputError(f"{path}:{first}: column {i + 1} has no name; the first line must name every column")
        if name in header[:i]:
            raise InputError(f"{path}:{first}: column '{name}' is named twice; names must differ")
    for number, cells in rows:
        if len(cells) != len(header):
            raise InputError(f"{path}:{number}: {counted(len(cells), 'cell')} where the header names {counted(len(header), 'column')}; "
                             "the line is damaged or the header is not its own")
    table = pd.DataFrame([cells for _, cells in rows], columns=header, index=[number for number, _ in rows], dtype=str)
    table.attrs.update(path=path, comments=comments)
    return table


def _cells(path, number, line):
    try:
        return [cell.strip() for cell in next(csv.reader([line], skipinitialspace=True, strict=True))]
    except csv.Error as error:
        raise InputError(f"{path}:{number}: {error}; quote a cell as \"...\"") from None


def numbers(table, column):
    """A column of `read_table()` as floats; an empty cell is NaN."""
    values = pd.to_numeric(table[column].replace("", "nan"), errors="coerce")
    no_number = values.isna() & ~table[column].str.lower().isin(["", "nan", "-nan"])
    if no_number.any():
        line = no_number.idxmax()
        raise InputError(f"{table.attrs['path']}:{line}: column '{column}' holds '{table[column][line]}'; a number is needed")
    return values.astype(float)


def find_column(table, name):
    """The column `name`, else the one that ends in it (`hardening_xi` is `material.hardening_xi`); None if there is none."""
    if name in table:
        return name
    found = [column for column in table if column.endswith("." + name)]
    if len(found) > 1:
        raise InputError(f"{table.attrs['path']}: '{name}' may be {' or '.join(found)}; name one of them '{name}'")
    return found[0] if found else None


def no_column(table, *names):
    """Text for columns that are missing: what each may have meant, and what there is."""
    def meant(name):
        close = difflib.get_close_matches(name, table.columns, n=1)
        return f"'{name}'" + (f" (did you mean '{close[0]}'?)" if close else "")

    return f"{table.attrs['path']}: no column {', '.join(meant(name) for name in names)}; there are: {', '.join(table.columns)}"


def read_series(path, dtype=None):
    """A table as pandas reads it; a last line without its end, left by a kill, is dropped."""
    text = read_text(path)
    whole = text[:text.rfind("\n") + 1]
    try:
        return pd.read_csv(io.StringIO(whole), comment="#", skipinitialspace=True, float_precision="round_trip", dtype=dtype)
    except (ValueError, OverflowError) as error:  # also those of pandas
        raise InputError(f"{path}: {error}") from None


def number_text(value):
    """Shortest decimal text that reads back to the same double: 5, 0.1, 1e-20, nan; a negative zero is 0."""
    value = float(value) + 0.0  # + 0.0: a negative zero is 0
    return f"{value:.0f}" if value.is_integer() and abs(value) < 1e15 else repr(value)


def csv_text(table, nothing="nan"):
    """A DataFrame as CSV with `number_text()` for its floats; NaN is written as `nothing`."""
    text = table.copy()
    for column in text.select_dtypes("float"):
        text[column] = [nothing if np.isnan(value) else number_text(value) for value in text[column]]
    return text.to_csv(index=False, lineterminator="\n")
