#!/usr/bin/python3
"""A material point method in numpy, to be read from top to bottom; it solves cases that `mpm-validate export` wrote.

The material is a cloud of particles that carry mass, velocity and stress. A grid, thrown away after every step, solves the equation of
motion: particles -> grid (mass, momentum, internal force), gravity and contact on the grid, grid -> particles (velocity, position, stress).
Weights are quadratic B-splines. Each particle also keeps the gradient C of the velocity around it, so that rotation survives the way through
the grid (APIC: Jiang et al. 2015); the same gradient deforms it, and the divergence of the stress needs no derivative of the weights (MLS-MPM:
Hu et al. 2018).

Laws: hencky_elastic, weakly_compressible_fluid without viscosity, cohesive_cam_clay with M = 0 and no cohesion. Boundaries: half-spaces; one
normal to an axis acts at its plane (second order in dx), any other on the nodes behind it (first order). Particles that leave the domain are
kept.

usage: numpy_mpm.py EXPORTED RESULTS [RUN...]      then: mpm-validate grade CASE --results RESULTS
"""

import csv
import itertools
import json
import pathlib
import shutil
import sys

import h5py
import numpy as np

IDENTITY = np.eye(3)
OFFSETS = np.array(list(itertools.product(range(3), repeat=3)))  # the 27 nodes around a particle, from the lowest one on
COMPONENTS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


# ---- laws: each keeps a state per particle, deforms it by I + dt C, and gives the Kirchhoff stress tau = J sigma -------------------------

class Elastic:
    """tau = K tr(eps) I + 2 G dev(eps), eps = 1/2 ln b, b = F F^T."""

    def __init__(self, keys, stress, ratio, internal):
        young, poisson = keys["young_modulus_pa"], keys["poisson_ratio"]
        self.bulk, self.shear = young / (3 * (1 - 2 * poisson)), young / (2 * (1 + poisson))
        tau = stress * ratio[:, None, None]
        mean = np.trace(tau, axis1=1, axis2=2)[:, None, None] / 3 * IDENTITY
        values, axes = np.linalg.eigh(mean / (3 * self.bulk) + (tau - mean) / (2 * self.shear))
        self.b = np.einsum("pik,pk,pjk->pij", axes, np.exp(2 * values), axes)

    def update(self, gradient):
        self.b = gradient @ self.b @ gradient.transpose(0, 2, 1)

    def stress(self):
        values, axes = np.linalg.eigh(self.b)
        strain = 0.5 * np.log(values)
        volume = strain.sum(axis=1, keepdims=True)
        principal = self.bulk * volume + 2 * self.shear * (strain - volume / 3)
        return np.einsum("pik,pk,pjk->pij", axes, principal, axes)

    def ratio(self):
        return np.sqrt(np.linalg.det(self.b))


class Fluid:
    """sigma = -p I, p = K/n (J^-n - 1); no tension."""

    def __init__(self, keys, stress, ratio, internal):
        if keys.get("viscosity_pa_s", 0.0) > 0.0:
            sys.exit("numpy_mpm: no viscosity")
        self.bulk, self.exponent, self.tension, self.j = keys["bulk_modulus_pa"], keys["tait_exponent"], keys.get("carries_tension", False), ratio

    def update(self, gradient):
        self.j = self.j * np.linalg.det(gradient)

    def stress(self):
        pressure = self.bulk / self.exponent * (self.j ** -self.exponent - 1)
        if not self.tension:
            pressure = np.maximum(pressure, 0.0)
        return -(self.j * pressure)[:, None, None] * IDENTITY

    def ratio(self):
        return self.j


class SlipperySnow:
    """Cam-Clay without friction and cohesion: p = K (x - X + X_0), x = -ln J, kept within 0 <= p <= p_c = K sinh(xi X)."""

    def __init__(self, keys, stress, ratio, internal):
        if keys["critical_state_slope"] != 0.0 or keys["cohesion_beta"] != 0.0:
            sys.exit("numpy_mpm: cohesive_cam_clay only with M = 0 and beta = 0")
        self.bulk = keys["young_modulus_pa"] / (3 * (1 - 2 * keys["poisson_ratio"]))
        self.xi, self.x, self.plastic = keys["hardening_xi"], -np.log(ratio), internal
        self.start = np.arcsinh(keys["preconsolidation_pressure_pa"] / self.bulk) / self.xi

    def update(self, gradient):
        self.x = self.x - np.log(np.linalg.det(gradient))
        total = self.x + self.start
        self.plastic = np.minimum(self.plastic, total)  # pulled: it tears, without stress
        yields = total - self.plastic > np.sinh(self.xi * np.maximum(self.plastic, 0.0))
        wanted = total[yields]
        root = np.maximum(self.plastic[yields], 0.0)
        for _ in range(30):  # Newton's method on X + sinh(xi X) = x + X_0, which is convex for X > 0
            root = root - (root + np.sinh(self.xi * root) - wanted) / (1 + self.xi * np.cosh(self.xi * root))
        self.plastic[yields] = np.where(wanted > 0.0, root, wanted)  # what is looser than at first has no strength

    def stress(self):
        return -self.bulk * (self.x + self.start - self.plastic)[:, None, None] * IDENTITY

    def ratio(self):
        return np.exp(-self.x)


LAWS = {"hencky_elastic": Elastic, "weakly_compressible_fluid": Fluid, "cohesive_cam_clay": SlipperySnow}


# ---- one run ---------------------------------------------------------------------------------------------------------------------------

class Body:
    """The particles of a run and how they move."""

    def __init__(self, run, folder):
        with h5py.File(folder / "particles.h5") as file:
            data = {name: file[name][()] for name in file}
        vector = [("x_m", "y_m", "z_m"), ("vx_m_s", "vy_m_s", "vz_m_s")]
        self.position, self.velocity = (np.stack([data[name] for name in names], axis=1) for names in vector)
        self.id, self.mass, self.volume = data["id"].astype(int), data["mass_kg"], data["volume_m3"]
        self.gradient = np.stack([np.stack([data[f"dv{v}_d{x}_1_s"] for x in "xyz"], axis=1) for v in "xyz"], axis=1)
        stress = np.empty((len(self.mass), 3, 3))
        for name, (i, j) in COMPONENTS.items():
            stress[:, i, j] = stress[:, j, i] = data[f"stress_{name}_pa"]
        model = run["material"]["model"]
        if model not in LAWS:
            sys.exit(f"numpy_mpm: no law '{model}'")
        self.law = LAWS[model](run["material"], stress, data["volume_ratio"], data["internal"])
        self.boundaries = [{**boundary, "normal": np.array(boundary["normal"])} for boundary in run["boundaries"]]
        self.gravity = np.array(run["gravity_m_s2"])
        for boundary in self.boundaries:
            if boundary["shape"] != "half-space":
                sys.exit(f"numpy_mpm: no boundary of the shape '{boundary['shape']}'")
        self.mirrors = ["xyz".index(plane[0]) for plane in run["symmetry_planes"]]
        self.dx, self.wave_speed = run["suggestion"]["cell_size_m"], run["suggestion"]["wave_speed_m_s"]
        self.origin = np.array(run["suggestion"]["grid_origin_m"])

    def stable_step(self):
        return 0.4 * self.dx / (self.wave_speed + np.sqrt((self.velocity ** 2).sum(axis=1).max()))

    def step(self, time, dt, impulses):
        """Symplectic Euler: the velocities first, positions and stresses with the new ones. Adds to the impulse of each boundary."""
        place = (self.position - self.origin) / self.dx  # in cells
        base = np.floor(place - 0.5).astype(int)
        corner, top = base.min(axis=0) - 2, base.max(axis=0) + 5  # with two empty nodes on all sides, for the columns across a wall
        for axis in self.mirrors:  # the nodes beyond a mirror plane and their images are all in the box
            corner[axis], top[axis] = min(corner[axis], -2), max(top[axis], 3)
        shape = top - corner
        near = place - base  # 0.5 .. 1.5
        weight_1d = np.stack([0.5 * (1.5 - near) ** 2, 0.75 - (near - 1) ** 2, 0.5 * (near - 0.5) ** 2], axis=1)  # particle, node, axis
        weight = weight_1d[:, OFFSETS[:, 0], 0] * weight_1d[:, OFFSETS[:, 1], 1] * weight_1d[:, OFFSETS[:, 2], 2]
        node = np.ravel_multi_index(tuple(np.moveaxis(base[:, None, :] + OFFSETS - corner, 2, 0)), shape)
        arm = (OFFSETS - near[:, None, :]) * self.dx  # from the particle to its nodes

        # Particles to grid: the affine momentum and the internal force enter through one matrix.
        affine = self.mass[:, None, None] * self.gradient - (4 * dt / self.dx ** 2 * self.volume)[:, None, None] * self.law.stress()
        momentum_part = weight[:, None, :] * ((self.mass[:, None] * self.velocity)[:, :, None] + affine @ arm.transpose(0, 2, 1))
        count = int(np.prod(shape))
        mass = np.bincount(node.ravel(), (weight * self.mass[:, None]).ravel(), count)
        momentum = np.stack([np.bincount(node.ravel(), momentum_part[:, i].ravel(), count) for i in range(3)], axis=1)
        index = np.stack(np.unravel_index(np.arange(count), shape), axis=1) + corner
        for axis in self.mirrors:
            fold(mass.reshape(shape), momentum.reshape(*shape, 3), axis, -corner[axis])

        # The grid: gravity, then the boundaries one after the other.
        full = mass > 0.0
        velocity = np.zeros_like(momentum)
        velocity[full] = momentum[full] / mass[full, None] + dt * self.gravity
        place_of_nodes = self.origin + self.dx * index
        own = np.ones(count)  # images carry no impulse of their own, nodes on a mirror plane half of it
        for axis in self.mirrors:
            own *= np.where(index[:, axis] < 0, 0.0, np.where(index[:, axis] == 0, 0.5, 1.0))
        for number, boundary in enumerate(self.boundaries):
            for nodes, share in self.reached(boundary, place_of_nodes, shape, time):
                changed = contact(mass[nodes], velocity[nodes], share, boundary)
                impulses[number] += ((mass * own)[nodes, None] * (velocity[nodes] - changed)).sum(axis=(0, 1))
                velocity[nodes] = changed

        # Grid to particles.
        part = weight[:, :, None] * velocity[node]
        self.velocity = part.sum(axis=1)
        self.gradient = 4 / self.dx ** 2 * (part.transpose(0, 2, 1) @ arm)
        self.position = self.position + dt * self.velocity
        self.law.update(IDENTITY + dt * self.gradient)

    def reached(self, boundary, places, shape, time):
        """The nodes on which a half-space acts, as an array (row, column), and for each row the share of contact(). A wall normal to an axis
        acts on three rows of nodes: the first that is half a cell or more before it, and the two behind. Their normal velocities are held
        proportional to the distance from the plane, so that they vanish on it; if the plane is on nodes, this is the mirror image. Nodes
        further behind, and all nodes behind another wall, are stopped one by one."""
        depth, normal = depth_of(places, boundary, time) / self.dx, boundary["normal"]
        axis = np.argmax(np.abs(normal))
        rows = np.moveaxis(np.arange(len(places)).reshape(shape), axis, 0).reshape(shape[axis], -1)[::1 if normal[axis] > 0 else -1]
        distance = depth[rows[:, 0]]  # of each row from a wall normal to the axis, rising
        first = np.searchsorted(distance, 0.5 - 1e-9)
        if np.abs(normal[axis]) < 1 or not 2 <= first < len(rows) or not self.has_room(places[rows[first, 0]], axis, normal, time):
            return [(np.flatnonzero(depth < 1e-9)[None, :], [0.0])]
        return [(rows[:first - 2].reshape(1, -1), [0.0]), (rows[first - 2:first + 1], distance[first - 2:first + 1] / distance[first])]

    def has_room(self, place, axis, normal, time):
        """Whether no mirror plane and no wall opposite acts on a row of nodes too, which is at `place` along the axis."""
        opposite = [wall for wall in self.boundaries if wall["normal"] @ normal <= -0.5]
        return (axis not in self.mirrors or place[axis] > 1.5 * self.dx) and all(
            depth_of(place, wall, time) > (1.5 - 1e-9) * self.dx for wall in opposite)


def depth_of(places, boundary, time):
    """Distance of places from a half-space; inside it is negative."""
    return (places - boundary["point_m"] - time * np.array(boundary["velocity_m_s"])) @ boundary["normal"]  # a surface travels with its velocity


def fold(mass, momentum, axis, middle):
    """Adds to each node the part of the image particles beyond a mirror plane through the plane `middle` of nodes, and mirrors the sum."""
    mass, momentum = np.moveaxis(mass, axis, 0), np.moveaxis(momentum, axis, 0)
    sign = np.ones(3)
    sign[axis] = -1.0
    for k in range(min(middle, len(mass) - middle - 1) + 1):
        right, left = middle + k, middle - k
        total, flow = mass[right] + mass[left], momentum[right] + sign * momentum[left]
        mass[right], mass[left], momentum[right], momentum[left] = total, total, flow, sign * flow


def contact(mass, velocity, share, boundary):
    """What a half-space leaves of the velocity (row, column, axis) of nodes of the mass (row, column). If it holds them, the nodes of a column
    move towards it with their share of one velocity, the one that keeps their momentum weighted by the share: 0 is rest."""
    normal, share = boundary["normal"], np.reshape(share, (-1, 1, 1))
    velocity, mass = velocity - boundary["velocity_m_s"], mass[:, :, None]
    held = share * (share * mass * velocity).sum(axis=0) / np.maximum((share ** 2 * mass).sum(axis=0), 1e-300)
    impulse = (mass * (velocity - held)).sum(axis=0)  # of the column on the wall, if the wall held it in all directions
    push = -impulse @ normal
    sliding = np.sqrt(((impulse + push[:, None] * normal) ** 2).sum(axis=1))
    friction = boundary["friction"] * np.maximum(push, 0.0)
    grip = np.ones_like(push) if boundary["contact"] == "no_slip" else np.minimum(friction / np.maximum(sliding, 1e-300), 1.0)
    across = ((held - velocity) @ normal)[:, :, None] * normal
    change = across + grip[:, None] * (held - velocity - across)
    if boundary["contact"] == "separable":
        change = change * ((push > 0.0) & has_arrived(mass[:, :, 0], share[:, 0, 0]))[:, None]
    return velocity + change + boundary["velocity_m_s"]


def has_arrived(mass, share):
    """Whether the material of each column (row, column) begins at most a tenth of a cell before the wall: by the ratio of the masses of the
    other nodes to that of the last one, whose share is 1. B-splines reach further than the material."""
    if len(share) == 1:
        return np.ones(mass.shape[1], dtype=bool)
    there = tail(0.1 - share / (1.0 - share[-2]))  # distance of the nodes before the wall: share times that of the last one
    return mass[:-1].sum(axis=0) * there[-1] >= there[:-1].sum() * mass[-1]


def tail(y):
    """Integral of the B-spline from y to its end, y in cells from the node."""
    far, near = np.clip(1.5 - np.abs(y), 0.0, 1.0) ** 3 / 6.0, 0.5 - np.abs(y) * (0.75 - y ** 2 / 3.0)
    half = np.where(np.abs(y) < 0.5, near, far)
    return np.where(y < 0.0, 1.0 - half, half)


def solve(run, exported, results):
    """Moves the particles through times_s and writes what the case asks for."""
    body, time = Body(run, exported / run["id"]), 0.0
    target = results / run["id"]
    target.mkdir(parents=True, exist_ok=True)
    names = [boundary["name"] for boundary in run["boundaries"]]
    wanted = [column["name"] for column in run["results"].get("states", {}).get("columns", [])]
    with h5py.File(target / "states.h5", "w") as states, open(target / "forces.csv", "w", newline="", encoding="utf-8") as file:
        forces = csv.writer(file)
        forces.writerow(["time_s", "boundary", "force_x_n", "force_y_n", "force_z_n"])
        for number, end in enumerate(run["results"]["times_s"], start=1):
            impulses, start = np.zeros((len(names), 3)), time
            while end - time > 1e-12 * end:
                limit = run["time_step_s"] or body.stable_step()
                dt = (end - time) / max(1, round((end - time) / limit) if run["time_step_s"] else np.ceil((end - time) / limit))
                body.step(time, dt, impulses)
                time += dt
            time = end
            for name, impulse in zip(names, impulses):
                forces.writerow([end, name, *(impulse / (end - start))])
            if wanted:
                write_state(states.create_group(f"{number:04}"), body, wanted)


def write_state(group, body, wanted):
    ratio = body.law.ratio()
    stress = body.law.stress() / ratio[:, None, None]
    columns = {"id": body.id, "volume_ratio": ratio}
    columns |= {f"{axis}_m": body.position[:, i] for i, axis in enumerate("xyz")} | {f"v{axis}_m_s": body.velocity[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"stress_{name}_pa": stress[:, i, j] for name, (i, j) in COMPONENTS.items()}
    for name in wanted:
        group[name] = columns[name]


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    exported, results = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    case = json.loads((exported / "case.json").read_text(encoding="utf-8"))
    for run in case["runs"]:
        if len(sys.argv) > 3 and run["id"] not in sys.argv[3:]:
            continue
        print(f"{run['id']}: {run['title']}, {run['particles']['count']} particles", file=sys.stderr, flush=True)
        solve(run, exported, results)
    shutil.copy(exported / "case.json", results)  # names the case and the level
    (results / "solver.json").write_text(json.dumps({"name": "numpy_mpm", "remark": "validation/foreign/numpy_mpm.py"}), encoding="utf-8")


if __name__ == "__main__":
    main()
