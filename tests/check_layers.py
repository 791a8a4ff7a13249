#!/usr/bin/python3
"""Checks the dependencies between the folders of the library: reads every #include below libmpm/ and fails

- if a folder includes one above it (the order is LAYERS below, as in libmpm/CMakeLists.txt),
- if a folder includes a library that its layer must not use,
- where headers and sources form a circle: a circle between files, a file being a header with its source,
- if a text in the core names a table of a case file ("[domain]", "numerics.cfl"),
- if a folder or a layer of libmpm/CMakeLists.txt is not listed here.

usage: check_layers.py [SOURCE_DIR]    prints every violation as file:line: text; exit code 1 if there is one
"""

import pathlib
import re
import sys

# From the bottom up. A layer: its name, its folders in their order, and the libraries that it may include.
LAYERS = (
    ("core", ("base", "material", "boundary", "core", "source"), {"Eigen", "omp.h"}),
    ("parallel", ("parallel",), {"Eigen", "omp.h"}),
    ("mpi", ("mpi",), {"mpi.h"}),
    ("io", ("io", "config"), {"Eigen", "omp.h", "fmt", "nlohmann", "hdf5.h", "zlib.h", "toml++"}),
    ("impact", ("impact", "observe"), {"Eigen", "omp.h", "fmt", "nlohmann", "boost"}),
    ("driver", ("driver",), {"Eigen", "omp.h", "fmt", "nlohmann", "boost"}),
    ("campaign", ("campaign",), {"Eigen", "omp.h", "fmt", "nlohmann", "toml++"}),
)
LIBRARIES = {"mpi.h", "Eigen", "omp.h", "fmt", "nlohmann", "hdf5.h", "zlib.h", "toml++", "boost", "CLI", "gtest", "gmock", "benchmark", "sundials"}
# A string in the core that names a table of a case: components of the core know their own keys only.
TABLES = "material|conveyor|obstacle|body|wall|terrain|domain|numerics|measurement|output"
STRING = re.compile(r'"((?:[^"\\]|\\.)*)"')
NAMES_A_TABLE = re.compile(rf"\[(?:{TABLES})\]|\b(?:{TABLES})(?:\[\d*\])?\.\w")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def includes(file):
    """(line, quoted, name) of every #include of a file."""
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
        if found := INCLUDE.match(line):
            yield number, found.group(1) == '"', found.group(2)


def circles(graph):
    """Strongly connected sets of more than one node (Tarjan), each sorted."""
    index, low, stack, found = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in graph[node]:
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            members = []
            while not members or members[-1] != node:
                members.append(stack.pop())
            if len(members) > 1:
                found.append(sorted(members))

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return found


def violations(source_dir):
    library = source_dir / "libmpm"
    order, allowed = {}, {}
    for _, folders, libraries in LAYERS:
        for folder in folders:
            order[folder] = len(order)
            allowed[folder] = libraries
    for folder in sorted(p for p in library.iterdir() if p.is_dir()):
        if folder.name not in order:
            yield f"libmpm/{folder.name}: a folder that {pathlib.Path(__file__).name} does not list; add it to LAYERS"
    cmake = (library / "CMakeLists.txt").read_text(encoding="utf-8")
    declared = [(name, tuple(folders.split())) for name, folders in re.findall(r"mpm_layer\((\w+) FOLDERS ([\w ]+?) LINKS", cmake)]
    expected = [(name, folders) for name, folders, _ in LAYERS]
    if declared != expected:
        yield f"libmpm/CMakeLists.txt: declares the layers {declared}, expected are {expected}"

    graph = {}
    for file in sorted(library.glob("*/*.?pp")):
        folder, place = file.parent.name, file.relative_to(source_dir)
        unit = f"{folder}/{file.stem}"
        graph.setdefault(unit, set())
        if folder in LAYERS[0][1]:
            for line, text in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
                if not INCLUDE.match(text) and any(NAMES_A_TABLE.search(string) for string in STRING.findall(text.split("//")[0])):
                    yield f"{place}:{line}: names a table of a case; let the layer above add it: {text.strip()}"
        for line, quoted, name in includes(file):
            where = f"{place}:{line}"
            if name.startswith("libmpm/"):
                target = name.removeprefix("libmpm/")
                other = target.split("/")[0]
                if not (library / target).is_file():
                    yield f"{where}: '{name}' does not exist"
                elif order.get(other, 0) > order.get(folder, 0):
                    yield f"{where}: {folder} includes {other}, which is above it"
                if target.removesuffix(".hpp") != unit:
                    graph[unit].add(target.removesuffix(".hpp"))
            elif quoted and not (name == "mpm_commit.hpp" and unit == "driver/build_info"):
                yield f"{where}: \"{name}\" is not included by its path from the top of the sources"
            else:
                root = name.split("/")[0]
                if root in LIBRARIES and root not in allowed.get(folder, LIBRARIES):
                    yield f"{where}: {folder} includes {name}, a library that its layer must not use"
    for circle in circles({unit: {o for o in others if o in graph} for unit, others in graph.items()}):
        yield "circle: " + " <-> ".join(circle)


def main():
    source_dir = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parents[1])
    found = list(violations(source_dir))
    for text in found:
        print(text)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
