"""The command line: python3 -m mpmtools fit|plot|render|view|film|design|scale|import-avaframe|json-schema."""

import argparse
import importlib
import math
import os
import re
import sys
import traceback

from mpmtools import __version__
from mpmtools.errors import InputError, MpmError

EPILOG = """\
examples:
  python3 -m mpmtools fit out/campaign/w5/results.csv --breakdown
  python3 -m mpmtools plot out/run --times 0.2,3,6
  python3 -m mpmtools render out/run --field velocity

Exit codes: 0 ok, 2 usage or numbers out of range, 4 a file is missing or damaged.
In Python: from mpmtools import Run; Run("out/run").series is a pandas DataFrame."""

FILTER_HELP = "keep rows where this holds, such as cell_size_m=0.25, hardening_xi=0.5,5, froude_number<=3; may be repeated"


def number(least=-math.inf, most=math.inf, kind=float):
    """The type of an option: a finite number between two limits."""
    limits = f"from {least:g}" * (least > -math.inf) + f" to {most:g}" * (most < math.inf)

    def read(text):
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not least <= value <= most or abs(value) == math.inf:
            raise argparse.ArgumentTypeError(f"'{text}': give a {'whole ' if kind is int else ''}number {limits}".rstrip())
        return value

    return read


def parser():
    top = argparse.ArgumentParser(
        prog="python3 -m mpmtools", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Evaluates and draws the runs of `mpm`: the regressions of the paper, pictures of single runs.")
    top.add_argument("--version", action="version", version=f"mpmtools {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND", title="commands")

    def command(name, text, module):  # loaded when the command is run: others do without its packages
        added = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        added.set_defaults(module=module)
        return added

    fit = command("fit", "the paper's regressions of run-up and pressure height (Eqs. 7 to 10) over tables of runs", "fit.text")
    fit.add_argument("tables", nargs="+", metavar="RESULTS.csv", help="result tables of campaigns, one row a run")
    fit.add_argument("--filter", action="append", default=[], metavar="'COLUMN OP VALUE'", help=FILTER_HELP)
    fit.add_argument("--breakdown", action="store_true", help="errors by Froude number, M' and xi, too")
    form = fit.add_mutually_exclusive_group()
    form.add_argument("--csv", choices=["coefficients", "scores"], help="one table as CSV; scores come with all their groups")
    form.add_argument("--json", action="store_true", help="everything as JSON")

    plot = command("plot", "pictures of one run: heights, pressure profile, forces, side view", "figures.run_pictures")
    plot.add_argument("directory", metavar="DIR", help="result folder of `mpm run`")
    plot.add_argument("--out", metavar="FOLDER", help="folder for the pictures (default: DIR/post)")
    plot.add_argument("--times", metavar="T,T,...", help="s: sections of the side view (default: first contact, middle, end)")
    plot.add_argument("--format", choices=["png", "pdf", "svg"], default="png")

    render = command("render", "3D picture of one frame of a run, rendered by ParaView without a screen", "figures.view_3d")
    render.add_argument("directory", metavar="DIR", help="result folder of `mpm run`, with frames")
    render.add_argument("--time", type=number(), metavar="T", help="s; the nearest frame is taken (default: the last)")
    render.add_argument("--field", choices=["density", "pressure", "stress_xx", "velocity"], default="stress_xx",
                        help="what the colours show (default: %(default)s)")
    render.add_argument("--out", metavar="FILE.png", help="picture to write (default: DIR/post/view_3d.png)")
    render.add_argument("--size", default="1600x1000", metavar="WIDTHxHEIGHT", help="pixels (default: %(default)s)")

    view = command("view", "an interactive page of a run: rotate the view, play through time, choose the quantity that the colours show",
                   "figures.view_page")
    view.add_argument("directory", metavar="DIR", help="result folder of `mpm run`, with frames")
    view.add_argument("--out", metavar="FILE.html", help="page to write (default: DIR/post/view.html)")
    view.add_argument("--particles", type=number(1000, kind=int), default=6_000_000, metavar="N",
                      help="in all frames together; a run with more is thinned (default: %(default)s)")

    film = command("film", "the snow of a run as a surface: a film of its frames, or a picture of one", "figures.film")
    film.add_argument("directory", metavar="DIR", help="result folder of `mpm run`, with frames")
    film.add_argument("--time", type=number(), metavar="T", help="s; a picture of the nearest frame in place of a film")
    film.add_argument("--field", choices=["snow", "speed", "pressure"], default="snow", help="what the colours show (default: %(default)s, white)")
    film.add_argument("--out", metavar="FILE", help="film (.mp4, .webm) or picture (.png) to write (default: DIR/post/film.mp4, snow.png)")
    film.add_argument("--size", default="960x600", metavar="WIDTHxHEIGHT", help="pixels, even (default: %(default)s)")
    film.add_argument("--slow", type=number(0.001, 1000.0), default=1.0, metavar="S", help="frames a second over those of real time (default: %(default)s)")
    film.add_argument("--kilobits", type=number(1, 1_000_000, int), default=1200, metavar="N", help="a second of the film (default: %(default)s)")

    design = command("design", "the page, the JSON and the tables of a design, from the finished runs of `mpm design`", "design.page")
    design.add_argument("directory", metavar="DIR", help="folder of `mpm design`")

    scale = command("scale", "predicted efficiency on many ranks, from the counts of a run on several ranks", "scale")
    scale.add_argument("directory", metavar="DIR", help="result folder of such a run (it holds ranks.json)")
    scale.add_argument("--particles", default="1e8,1e9", metavar="N,N,...", help="default: %(default)s")
    scale.add_argument("--ranks", default="64,256,1024,4096", metavar="P,P,...", help="default: %(default)s")
    scale.add_argument("--speed", type=number(1e-6), default=12.0, metavar="M",
                       help="million particle-steps a second of one rank (default: %(default)s, one core)")
    scale.add_argument("--latency-us", type=number(0.0), default=2.0, metavar="T", help="of a message (default: %(default)s)")
    scale.add_argument("--bandwidth-gb-s", type=number(1e-6), default=1.0, metavar="B",
                       help="of the network for each rank: that of a node over its ranks (default: %(default)s)")

    imported = command("import-avaframe", "a case and a site from an avalanche of AvaFrame's com1DFA at one point", "avaframe.case_files")
    imported.add_argument("directory", metavar="DIR", help="folder of the avalanche (with Inputs and Outputs), or of its rasters")
    imported.add_argument("--at", required=True, metavar="X,Y", help="the mast, in the coordinates of the rasters, m; may be negative: --at -100,50")
    imported.add_argument("--mast-width", type=float, default=1.0, metavar="W", help="m (default: %(default)s)")
    imported.add_argument("--density", type=float, default=200.0, metavar="RHO",
                          help="kg/m^3 (default: %(default)s, that of com1DFA's standard set-up)")
    imported.add_argument("--simulation", metavar="NAME", help="where the folder holds several")
    imported.add_argument("--dem", metavar="FILE", help="elevation, where DIR/Inputs does not hold just one raster")
    imported.add_argument("--terrain", action=argparse.BooleanOptionalAction, default=None,
                          help="take the terrain as the floor of the case, or a plane (default: the terrain, where it differs from a plane by more "
                          "than a tenth of the flow depth)")
    imported.add_argument("--out", default="out/avaframe", metavar="FOLDER", help="for case.toml, inflow.csv, site.toml and terrain.asc (default: %(default)s)")
    imported.add_argument("--force", action="store_true", help="overwrite such files in FOLDER")

    schema = command("json-schema", "the JSON schema of case files, for editors that complete and check keys as you type", "json_schema")
    schema.add_argument("--out", metavar="FILE", help="file to write (default: standard output)")
    return top


def _unexpected(options, error):
    """The message for an error that no reader of a file has foreseen, mostly a value of a wrong type or range in one."""
    inputs = getattr(options, "directory", None) or " ".join(getattr(options, "tables", []))
    places = [f"{os.path.basename(at.filename)}:{at.lineno}" for at in traceback.extract_tb(error.__traceback__) if "mpmtools" in at.filename]
    return (f"{inputs}: {type(error).__name__}: {error} (at {places[-1]}). A file there is damaged, or this is an error of mpmtools; "
            "MPMTOOLS_TRACEBACK=1 shows where")


def with_negative_values(words):
    """The words of a command line with each option and a value that begins with a minus as one word, as argparse wants it: --at=-100,50."""
    joined = []
    for word in words:
        if joined and re.fullmatch(r"--[a-z][a-z-]*", joined[-1]) and re.match(r"-\.?\d", word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def main(arguments=None):
    options = parser().parse_args(with_negative_values(sys.argv[1:] if arguments is None else arguments))
    try:
        code = importlib.import_module(f"mpmtools.{options.module}").run_command(options) or 0
        if sys.stdout is not None:  # None: it is closed
            sys.stdout.flush()
        return code
    except MpmError as error:
        print(f"mpmtools {options.command}: {error}", file=sys.stderr)
        return error.exit_code
    except ImportError as error:
        print(f"mpmtools: {error}, for {sys.executable}; install numpy, scipy, pandas, matplotlib, h5py and jinja2 for it, or use "
              "/usr/bin/python3 with Debian's python3-numpy, python3-scipy, ...", file=sys.stderr)
        return 5
    except OSError as error:
        if sys.stdout is not None:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is not written yet fails no second time
        if isinstance(error, BrokenPipeError):  # the reader of a pipe, such as head, has seen enough
            return 0
        print(f"mpmtools {options.command}: {error}", file=sys.stderr)
        return InputError.exit_code
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError, MemoryError, RecursionError) as error:
        if os.environ.get("MPMTOOLS_TRACEBACK"):
            raise
        print(f"mpmtools {options.command}: {_unexpected(options, error)}", file=sys.stderr)
        return InputError.exit_code


if __name__ == "__main__":
    sys.exit(main())
