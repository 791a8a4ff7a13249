#!/usr/bin/python3
"""Breaks one constant of the library at a time, and shows which checks of the validation notice.

For each mutation a copy of the tree under build/mutants is changed in one place, mpm-validate is built there, and the cases that should
notice run at level quick. A mutation that no check notices is a hole in the validation: exit code 1; so is one that does not build. One
whose text is no longer found in the source, or found more than once, ends the program: exit code 2; --list looks at all of them. So does a
case that fails without any mutation. A mutation none of whose cases exists in this tree cannot be noticed and counts as such.

usage: mutants.py [--list] [--jobs N] [--threads N] [NAME...]
"""

import argparse
import dataclasses
import json
import os
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PLACE = os.path.join(ROOT, "build", "mutants")
TREE, OUT = (os.path.join(PLACE, name) for name in ("tree", "out"))
BUILD = os.path.join(TREE, "build", "release")  # as far below the sources as that of ./run, so that ccache knows what that has compiled
TIME_LIMIT_S = 900  # of the cases of one mutation: a mutant may never come to rest


@dataclasses.dataclass
class Mutation:
    name: str
    what: str
    file: str
    old: str
    new: str
    cases: tuple  # those that should notice


LAWS = "libmpm/material/"
MUTATIONS = [
    Mutation("hardening_sign", "plastic compaction softens instead of hardening", LAWS + "cam_clay.hpp",
             "state.internal += r.d;", "state.internal = state.internal - r.d;", ("isotropic_compression",)),
    Mutation("yield_factor", "1 + 3 beta for 1 + 2 beta in the yield surface of the return map", "libmpm/material/cam_clay.cpp",
             "m2_ = slope_ * slope_ / (1.0 + 2.0 * beta_);", "m2_ = slope_ * slope_ / (1.0 + 3.0 * beta_);", ("isotropic_compression",)),
    Mutation("volume_ratio", "J takes the plastic volume change with the wrong sign", LAWS + "cam_clay.hpp",
             "+ (initial_internal_ - state.internal));", "- (initial_internal_ - state.internal));", ("isotropic_compression", "stress_paths")),
    Mutation("bulk_modulus", "K 1 % too large", LAWS + "hencky_elastic.hpp",
             "bulk_(p.young_modulus / (3.0 *", "bulk_(1.01 * p.young_modulus / (3.0 *", ("hydrostatic_column", "elastic_wave")),
    Mutation("bspline_weight", "the middle weight of the B-spline is 0.75 - 2^-13 - b^2", "libmpm/base/bspline.hpp",
             "0.75 - b * b", "0.7498779296875 - b * b", ("free_flight",)),
    Mutation("affine_scale", "the affine momentum of APIC 1 % too small", "libmpm/core/particle_to_grid.cpp",
             "(options.affine ? options.density * dx : 0.0)", "(options.affine ? 0.99 * options.density * dx : 0.0)", ("conservation",)),
    Mutation("folded_column", "slaves of a folded wall move 10 % too slowly", "libmpm/core/folded_wall.cpp",
             "{1.0, (d - 1.0) / d, (d - 2.0) / d}", "{1.0, 0.9 * (d - 1.0) / d, 0.9 * (d - 2.0) / d}", ("bar_on_wall",)),
    Mutation("separable_wall", "a folded separable wall holds what is pulled off it", "libmpm/core/node_column.hpp",
             "(tension >= 0.0 || is_open(column, surface.gap))", "(tension >= 1e30 || is_open(column, surface.gap))", ("bar_on_wall",)),
    Mutation("closed_gap", "a separable wall acts when material is half a cell before it", "libmpm/core/node_column.hpp",
             "closed_gap = 0.1;", "closed_gap = 0.5;", ("bar_on_wall",)),
    Mutation("dilatancy", "Drucker-Prager dilates 1 % too little", LAWS + "drucker_prager.hpp",
             "(dilatancy_slope_ / (3.0 * shear)) * d;", "(0.99 * dilatancy_slope_ / (3.0 * shear)) * d;", ("cone_paths",)),
    Mutation("inertial_number", "mu(I) takes the inertial number 1 % too small", LAWS + "drucker_prager.cpp",
             "hindrance_ = reference_inertial_number_ * 3.0 *", "hindrance_ = reference_inertial_number_ * 3.03 *", ("cone_paths",)),
    Mutation("edge_ratio", "the ends of an obstacle's sides take as much as other points", "libmpm/core/surface_contact.cpp",
             "max(edge.largest(impulse_of(edge.neighbour), dynamic * width * squared_speed)", "max(1e9 * impulse_of(edge.neighbour)", ("plate_in_jet",)),
    Mutation("edge_bernoulli", "the pressure at an edge falls by a quarter of what Bernoulli's law gives", "libmpm/core/surface_contact.cpp",
             "solid_.friction(), 0.5 * density_ *", "solid_.friction(), 0.125 * density_ *", ("plate_in_jet",)),
    Mutation("end_layers", "the layers at top and underside take as much as others", "libmpm/core/surface_contact.cpp",
             "if (depth < cell_rounding - 0.5 ||", "if (depth < 9.5 ||", ("plate_in_jet",)),
    Mutation("edge_margin", "the points of an obstacle's sides reach to its edges", "libmpm/boundary/contact_stencil.hpp",
             "edge_margin = 0.2;", "edge_margin = 0.0;", ("punch", "plate_in_jet")),
    Mutation("margin_at_rest", "the margins of an obstacle's sides let material in that stands round the edge",
             "libmpm/boundary/contact_stencil.cpp", "side.margin / other.width", "0.0 / other.width", ("fluid_at_rest", "hydrostatic_pile_up")),
    Mutation("particle_contact", "particles may be a cell behind the surface of an obstacle", "libmpm/core/particle_contact.hpp",
             "deepest_particle = 0.05;", "deepest_particle = 1.0;", ("hydrostatic_pile_up",)),
    Mutation("shock_viscosity", "the viscosity of shocks is a tenth", "libmpm/core/numerics.hpp",
             "shock_viscosity = 10.0;", "shock_viscosity = 1.0;", ("compaction_shock",)),
    Mutation("shock_stability", "the viscosity of shocks is bounded at a hundredth", "libmpm/core/transfer.hpp",
             "shock_stability = 0.25;", "shock_stability = 0.0025;", ("compaction_shock",)),
    Mutation("lumped_mass", "accelerations around obstacles are not corrected", "libmpm/core/lumped_mass.cpp",
             "(part == Part::full ? 1.0 : weight(x)) * density_", "0.0 * (part == Part::full ? 1.0 : weight(x)) * density_", ("plate_in_jet",)),
    Mutation("top_columns", "the last columns on the top of an obstacle take as much as others", "libmpm/boundary/contact_stencil.cpp",
             "if (p.depth > 0.5 + cell_rounding) continue;", "if (p.depth > -1.0) continue;", ("disc_in_round_jet",)),
    Mutation("retained_fraction", "AFLIP forgets at once what the grid cannot carry", "libmpm/core/step.cpp",
             "return 1.0 - std::min(1.0, dt * speed /", "return 0.1 - 0.1 * std::min(1.0, dt * speed /", ("conservation",)),
    Mutation("stress_transfer", "internal forces 1 % too small", "libmpm/core/particle_to_grid.cpp",
             "(-options.dt * 4.0 * inverse_dx)", "(-options.dt * 3.96 * inverse_dx)", ("hydrostatic_column", "elastic_wave")),
    Mutation("advection", "particles move 0.1 % too far in every step", "libmpm/core/grid_to_particle.cpp",
             "return position + dt_ * velocity;", "return position + 1.001 * dt_ * velocity;", ("free_flight",)),
    Mutation("gravity_sign", "gravity points upwards", "libmpm/core/numerics.hpp",
             "0.0, -std::cos(slope)", "0.0, std::cos(slope)", ("free_flight",)),
    Mutation("wall_friction", "Coulomb friction of walls 1 % too small", "libmpm/boundary/contact.cpp",
             "const double loss = -friction * approach;", "const double loss = -0.99 * friction * approach;", ("sliding_block",)),
    Mutation("wall_impulse", "a boundary reports 0.1 % less momentum than it took", "libmpm/boundary/impulse.hpp",
             "linear += given;", "linear += 0.999 * given;", ("conservation",)),
    Mutation("moment_arm", "the moment on a boundary has an arm 1 % too long", "libmpm/boundary/impulse.hpp",
             "angular += arm.cross(given);", "angular += 1.01 * arm.cross(given);", ("conservation",)),
    Mutation("layers", "layers of the obstacle report 0.1 % less momentum than they took; contact on nodes", "libmpm/core/grid_update.cpp",
             "layers[place_along(2, n)] += taken;", "layers[place_along(2, n)] += 0.999 * taken;", ("conservation",)),
    Mutation("surface_layers", "the same with contact at the surface", "libmpm/core/boundary_impulses.cpp",
             "sum.layer.push_back(layer.linear);", "sum.layer.push_back(0.999 * layer.linear);", ("conservation",)),
    Mutation("surface_friction", "Coulomb friction of an obstacle with contact at its surface 1 % too small", "libmpm/driver/scene.cpp",
             "return SurfaceSolid(std::move(solid), friction,",
             "return SurfaceSolid(std::move(solid), 0.99 * friction,", ("conservation",)),
    Mutation("obstacle_friction", "Coulomb friction of a box with contact on nodes 1 % too small", "libmpm/driver/scene.cpp",
             "return NodalSolid{std::move(solid), skin, Contact::separable, friction,",
             "return NodalSolid{std::move(solid), skin, Contact::separable, 0.99 * friction,", ("conservation",)),
    Mutation("mirror_plane", "a mirror plane returns 10 % less than its image to the nodes next to it", "libmpm/core/mirror.cpp",
             "before += flip * behind;", "before += 0.9 * flip * behind;", ("elastic_wave",)),
    Mutation("flip_ratio", "the share of FLIP 1 % too small", "libmpm/core/step.cpp",
             "case Transfer::flip: return scene.numerics.flip_ratio;", "case Transfer::flip: return 0.99 * scene.numerics.flip_ratio;", ("elastic_wave",)),
    Mutation("sinh_hardening", "xi 1 % too large in the increment of p_c", LAWS + "cam_clay.hpp",
             "const T h = law_.xi_ * x, h2 = h * h;", "const T h = 1.01 * law_.xi_ * x, h2 = h * h;", ("isotropic_compression",)),
    Mutation("drucker_prager", "the cone of Drucker-Prager 1 % less steep", LAWS + "drucker_prager.cpp",
             "slope_ = cone.slope, intercept_", "slope_ = 0.99 * cone.slope, intercept_", ("cone_paths",)),
    Mutation("mu_of_i", "I_0 of mu(I) 1 % too large", LAWS + "drucker_prager.cpp",
             "hindrance_ = reference_inertial_number_ * 3.0", "hindrance_ = 1.01 * reference_inertial_number_ * 3.0", ("cone_paths", "channel_flow")),
    Mutation("viscosity", "viscosity 1 % too small", LAWS + "weakly_compressible_fluid.hpp",
             "((viscosity_ / dt) * filled)", "((0.99 * viscosity_ / dt) * filled)", ("channel_flow",)),
    Mutation("cohesion", "the cohesion of Drucker-Prager 1 % too small", LAWS + "drucker_prager.cpp",
             "intercept_ = cone.intercept,", "intercept_ = 0.99 * cone.intercept,", ("cone_paths",)),
    Mutation("shear_transfer", "the shear stress pushes the grid along x 5 % too little", "libmpm/core/particle_to_grid.cpp",
             "ty = ms * columns.ty,", "ty = [&] { V t = ms * columns.ty; t[0] *= 0.95; t[4] *= 0.95; return t; }(),",
             ("thick_cylinder", "cavity_expansion")),
    Mutation("mean_profile", "the rows of the mean pressure profile weigh 5 % too little", "libmpm/observe/observer_list.cpp",
             "mean[i] += values[sample * width + i];", "mean[i] += 0.95 * values[sample * width + i];", ("avalanche",)),
    Mutation("conveyor_lattice", "the outermost row of the conveyor's particles is missing", "libmpm/impact/conveyor.cpp",
             "for (int j = mirror_y_ ? 0 : -half_count_; j < half_count_; ++j) {", "for (int j = mirror_y_ ? 0 : -half_count_; j + 1 < half_count_; ++j) {",
             ("conveyor_feeds",)),
    Mutation("conveyor_flux", "the window feeds 5 % too little", "libmpm/impact/conveyor.cpp",
             "* spacing_ + gone >= release_at_", "* spacing_ + 0.95 * gone >= release_at_", ("conveyor_feeds",)),
    Mutation("box_corner", "the edges of a box belong to the face further downstream, not upstream", "libmpm/boundary/outline.cpp",
             "further_up = nearest.normal.x() - side.normal.x();", "further_up = side.normal.x() - nearest.normal.x();", ("conservation",)),
    Mutation("skin", "nodes up to 0.45 in place of 0.5 cells before a curved surface belong to the solid", "libmpm/driver/scene.cpp",
             "0.0 : 0.5 * numerics.cell_size;", "0.0 : 0.45 * numerics.cell_size;", ("conservation",)),
    Mutation("steady_interval", "a flow counts as steady only within a hundredth of the tolerance", "libmpm/impact/steady.cpp",
             "allowed = criteria.tolerance * std::abs(end_value)", "allowed = 0.01 * criteria.tolerance * std::abs(end_value)", ("avalanche",)),
    Mutation("runup_percentile", "the median for the 99th percentile of the run-up", "libmpm/observe/runup.cpp",
             "height_of(0.99, near_)", "height_of(0.5, near_)", ("hydrostatic_pile_up",)),
]


def stop(message):
    print(f"mutants: {message}", file=sys.stderr)
    sys.exit(2)


def run(command, log, **arguments):
    """Exit code of a command whose output goes to a file; None if it took too long."""
    with open(log, "w", encoding="utf-8") as file:
        try:
            return subprocess.run(command, stdout=file, stderr=subprocess.STDOUT, check=False, **arguments).returncode
        except subprocess.TimeoutExpired:
            return None


def copy_tree(cases):
    """Brings build/mutants/tree up to the files that git knows or would add, of the validation's cases only those that run.
    Unchanged files keep their times, so that builds stay incremental."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT, stdout=subprocess.PIPE, check=True).stdout
    names = {name for name in listed.decode().split("\0") if name and os.path.isfile(os.path.join(ROOT, name))}
    names = {name for name in names if not name.startswith("validation/cases/") or name.split("/")[2] in cases}
    for name in names:
        with open(os.path.join(ROOT, name), "rb") as file:
            write_if_changed(os.path.join(TREE, name), file.read(), os.stat(os.path.join(ROOT, name)).st_mode)
    for folder, folders, files in os.walk(TREE):
        if folder == TREE and "build" in folders:
            folders.remove("build")
        for file in files:
            path = os.path.join(folder, file)
            if os.path.relpath(path, TREE) not in names:
                os.remove(path)


def write_if_changed(path, content, mode=0o644):
    if os.path.exists(path):
        with open(path, "rb") as file:
            if file.read() == content:
                return
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as file:
        file.write(content)
    os.chmod(path, mode)


def mutated(mutation):
    """The file's content with the one change."""
    with open(os.path.join(ROOT, mutation.file), encoding="utf-8") as file:
        text = file.read()
    count = text.count(mutation.old)
    if count != 1:
        stop(f"{mutation.name}: '{mutation.old}' occurs {count} times in {mutation.file}, not once; adapt the mutation in tests/mutants.py")
    return text.replace(mutation.old, mutation.new).encode()


def existing_cases(mutation):
    """Those of its cases that this tree has."""
    return [case for case in mutation.cases if os.path.isdir(os.path.join(ROOT, "validation", "cases", case))]


def build(name, jobs):
    """Whether it builds; otherwise it says where the compiler's messages are."""
    log = os.path.join(OUT, f"{name}.build.log")
    if run(["cmake", "--build", BUILD, "--parallel", str(jobs), "--target", "mpm-validate"], log) == 0:
        return True
    print(f"mutants: {name}: does not build, see {log}", file=sys.stderr)
    return False


def validate(name, cases, threads):
    """(cases ended in time, failed checks as 'case: quantity')"""
    directory = os.path.join(OUT, name)
    command = [os.path.join(BUILD, "bin", "mpm-validate"), "run", "--level", "quick", "--out", directory, "--threads", str(threads)]
    for case in cases:
        command += ["--case", case]
    code = run(command, os.path.join(OUT, f"{name}.log"), timeout=TIME_LIMIT_S)
    if code not in (0, 1, 5, None):
        stop(f"{name}: mpm-validate ended with exit code {code}, see {OUT}/{name}.log")
    with open(os.path.join(directory, "results.json"), encoding="utf-8") as file:
        results = json.load(file)
    failed = []
    for case in results["cases"]:
        if case["fault"]:
            failed.append(f"{case['name']}: {case['fault']}")
        worst = sorted((k for k in case["checks"] if k["verdict"] == "FAILED"), key=lambda k: -(k["tolerance_used"] or float("inf")))
        failed += [f"{case['name']}: {k['quantity']} ({k['text']['error']}, tolerance {k['text']['tolerance']})" for k in worst]
    return code is not None, failed


def main():
    parser = argparse.ArgumentParser(description="Break a constant on purpose and see which check fails")
    parser.add_argument("name", nargs="*", help="only these mutations")
    parser.add_argument("--list", action="store_true", help="name the mutations")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="of the build")
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="of the simulations")
    options = parser.parse_args()
    if options.list:
        for m in MUTATIONS:
            mutated(m)
            missing = [case for case in m.cases if case not in existing_cases(m)]
            print(f"{m.name:<17} {m.what} ({m.file}); should be noticed by {', '.join(m.cases)}" + (f" [no such case yet: {', '.join(missing)}]" if missing else ""))
        return 0
    known = {m.name: m for m in MUTATIONS}
    for name in options.name:
        if name not in known:
            stop(f"no mutation '{name}'; --list names them")
    chosen = [known[name] for name in options.name] or MUTATIONS
    changes = {m.name: mutated(m) for m in chosen}  # all before the first build: a text that is gone shows at once

    os.makedirs(OUT, exist_ok=True)
    cases = sorted({case for m in chosen for case in existing_cases(m)})
    copy_tree(cases)
    log = os.path.join(OUT, "configure.log")
    parts = [f"-DMPM_BUILD_{part}=OFF" for part in ("APP", "TESTS", "BENCHMARKS")]
    if run(["cmake", "-S", TREE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", *parts], log) != 0:
        stop(f"cannot configure, see {log}")
    print("unchanged: building and running the cases", file=sys.stderr)
    if not build("unchanged", options.jobs):
        return 2
    in_time, failed = validate("unchanged", cases, options.threads)
    if failed or not in_time:
        stop("cases fail without any mutation, so they show nothing: " + ("; ".join(failed) or "they do not end"))

    rows, survivors = [], []
    for m in chosen:
        start = time.monotonic()
        print(f"{m.name}: {m.what}", file=sys.stderr)
        if not existing_cases(m):
            survivors.append(m.name)
            rows.append((m.name, m.what, f"NOT NOTICED: no case {' or '.join(m.cases)} in this tree"))
            continue
        path = os.path.join(TREE, m.file)
        with open(path, "rb") as file:
            original = file.read()
        write_if_changed(path, changes[m.name])
        try:
            built = build(m.name, options.jobs)
            if built:
                in_time, failed = validate(m.name, existing_cases(m), options.threads)
        finally:
            write_if_changed(path, original)
        if not built:
            survivors.append(m.name)
            rows.append((m.name, m.what, "DOES NOT BUILD: adapt the mutation"))
            continue
        if not in_time:
            failed.append(f"did not end within {TIME_LIMIT_S} s")
        if not failed:
            survivors.append(m.name)
        more = f", and {len(failed) - 1} more" if len(failed) > 1 else ""
        rows.append((m.name, m.what, failed[0] + more if failed else "NOT NOTICED"))
        print(f"  {rows[-1][2]} ({time.monotonic() - start:.0f} s)", file=sys.stderr)

    print("| mutation | what is broken | first check that fails |\n|---|---|---|")
    for row in rows:
        print("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |")
    print(f"{len(rows) - len(survivors)} noticed, {len(survivors)} not" + (f": {', '.join(survivors)}" if survivors else ""))
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
