#!/usr/bin/python3
"""Runs the tests of python/mpmtools and of the study's analysis: run_tests.py [NAME...], NAME a module, class or test as unittest names them."""

import importlib.util
import pathlib
import sys
import unittest

PACKAGES = {"numpy": "python3-numpy", "scipy": "python3-scipy", "pandas": "python3-pandas", "matplotlib": "python3-matplotlib",
            "h5py": "python3-h5py", "jinja2": "python3-jinja2", "jsonschema": "python3-jsonschema"}
HERE = pathlib.Path(__file__).resolve().parent


def main():
    missing = [package for module, package in PACKAGES.items() if importlib.util.find_spec(module) is None]
    if missing:
        sys.exit(f"the tests of mpmtools need Debian's {', '.join(missing)}; install: apt-get install {' '.join(missing)}")
    sys.path[:0] = [str(HERE), *(str(HERE.parent.parent / name) for name in ("python", "validation/study", "scripts"))]  # mpmtools; analysis (of the study); reports
    loader = unittest.TestLoader()
    tests = loader.loadTestsFromNames(sys.argv[1:]) if sys.argv[1:] else loader.discover(str(HERE))
    if not tests.countTestCases():
        sys.exit("no test was found")
    sys.exit(not unittest.TextTestRunner(verbosity=2).run(tests).wasSuccessful())


if __name__ == "__main__":
    main()
