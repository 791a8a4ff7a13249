"""The snow as a surface: the density of the particles on a grid, and an image of where it passes a level, by rays from a camera.

Plain numpy and scipy; no graphics library and no screen. Lengths in m; arrays of points have the shape (count, 3).
"""

import numpy as np
from scipy.ndimage import gaussian_filter, label, map_coordinates, maximum_filter

from mpmtools.terrain import FINER, crossing

LEVEL = 0.2  # of the density that the snow has at the start, smoothed: the surface
SMOOTHING = 0.8  # cells: the lattice of the particles does not show, and threads a few particles across stay whole
LUMP = 20  # particles: smaller lumps that fly alone are left out
FAR = 3  # cells
LIGHT = np.array([-0.45, -0.55, 0.70]) / np.linalg.norm([-0.45, -0.55, 0.70])  # direction towards the sun
SKY_TOP, SKY_LOW = np.array([0.62, 0.75, 0.90]), np.array([0.93, 0.96, 0.99])
GROUND, MAST = np.array([0.74, 0.76, 0.77]), np.array([0.42, 0.36, 0.33])
SNOW = np.array([0.93, 0.95, 0.985])
FINEST = 1024  # intervals of the ground along an axis
SEEN = 6.0 * 1.3  # half boxes of the snow: farther away the ground has faded into the sky (draw)


def march(probe, start, end, halvings):
    """Way along many rays to where they come inside something; infinite where they do not.

    @param probe  of numbers of rays and ways along them: (is each place inside, how far the ray may go on from there)
    @param start, end  ways between which is looked. @param halvings  of the step that ends inside
    """
    way, last, found = start.copy(), start.copy(), np.full(len(start), np.inf)
    open_rays = np.flatnonzero(start < end)
    while open_rays.size:
        inside, step = probe(open_rays, way[open_rays])
        found[open_rays[inside]] = way[open_rays[inside]]
        step, open_rays = step[~inside], open_rays[~inside]
        last[open_rays] = way[open_rays]
        way[open_rays] += step
        open_rays = open_rays[last[open_rays] < end[open_rays]]
    met = np.flatnonzero(np.isfinite(found))
    found[met] = crossing(lambda ways: probe(met, ways)[0], last[met], found[met], halvings)
    return found


class LevelGround:
    """The ground z = 0."""

    def height(self, places):
        """m. @param places  (count, 2)"""
        return np.zeros(len(places))

    def hits(self, eye, rays, _most):
        """Way along each ray to the ground; infinite where it passes by."""
        with np.errstate(divide="ignore"):
            return np.where(rays[:, 2] < 0.0, -eye[:, 2] / rays[:, 2], np.inf)

    def normals(self, points):
        return np.broadcast_to([0.0, 0.0, 1.0], points.shape)


class UnevenGround:
    """The ground of a Terrain: the solver's cubic at the points of a finer grid, linear between them.

    Beyond the raster the heights of its edge go on: a picture needs ground up to the horizon, and no snow is there.
    """

    def __init__(self, terrain):
        finer = int(np.clip(FINEST // (max(terrain.height.shape) - 1), 1, FINER))
        x, y = (np.linspace(a[0], a[-1], finer * (len(a) - 1) + 1) for a in (terrain.x, terrain.y))
        self.low, self.high, self.spacing = np.array([x[0], y[0]]), np.array([x[-1], y[-1]]), terrain.spacing / finer
        self.heights = terrain.heights(x, y)
        self.slopes = np.gradient(self.heights, self.spacing)[::-1]  # along x, along y
        steps = [np.max(np.abs(np.diff(self.heights, axis=axis))) for axis in (0, 1)]
        self.steepest = float(np.hypot(*steps)) / self.spacing

    def _sample(self, field, places):
        at = ((places - self.low) / self.spacing).T[::-1]
        return map_coordinates(field, at, order=1, mode="nearest", prefilter=False)

    def height(self, places):
        """m. @param places  (count, 2)"""
        return self._sample(self.heights, places)

    def hits(self, eye, rays, most):
        """Way along each ray to the ground; infinite where it passes by, or meets the ground farther away than `most`.

        A point that is d above the ground moves on by d over the greatest rate at which ground and ray can approach:
        no hill is jumped over. Near the ground this becomes slow; there a quarter of an interval, or 0.2 % of the way
        (two pixels of a picture 500 pixels high), is the least step, and bisection finds the place in the step that
        ends below the ground.
        """
        closing = self.steepest * np.hypot(rays[:, 0], rays[:, 1]) - rays[:, 2]

        def probe(which, ways):
            points = eye[which] + ways[:, None] * rays[which]
            above = points[:, 2] - self.height(points[:, :2])
            return above <= 0.0, np.maximum(above / closing[which], np.maximum(0.25 * self.spacing, 0.002 * ways))

        return march(probe, np.zeros(len(rays)), np.where(closing > 0.0, most, 0.0), 20)  # to a millionth of the last step

    def normals(self, points):
        """Unit, upwards."""
        places = points[:, :2]
        on_raster = np.all((places >= self.low) & (places <= self.high), axis=1)
        x, y = (np.where(on_raster, -self._sample(slope, places), 0.0) for slope in self.slopes)
        normals = np.column_stack([x, y, np.ones(len(points))])
        return normals / np.linalg.norm(normals, axis=1, keepdims=True)


class SnowDensity:
    """Smoothed density over that of the start, and a property of the particles, on a grid of cubes 1.25 times as large as the particles were
    apart."""

    def __init__(self, positions, volumes, spacing, values=None):
        """@param volumes  of the particles at the start, m^3. @param values  one a particle, or None"""
        self.cell = 1.25 * spacing
        margin = 4
        low = positions.min(axis=0) - margin * self.cell
        self.low, self.shape = low, np.ceil((positions.max(axis=0) - low) / self.cell).astype(int) + margin
        total, weighted = (np.zeros(np.prod(self.shape)) for _ in range(2))
        place = (positions - low) / self.cell
        base = np.floor(place - 0.5).astype(int)
        offset = place - base
        weights = [0.5 * (1.5 - offset) ** 2, 0.75 - (offset - 1.0) ** 2, 0.5 * (offset - 0.5) ** 2]  # quadratic B-spline along each axis
        for i, j, k in np.ndindex(3, 3, 3):
            share = weights[i][:, 0] * weights[j][:, 1] * weights[k][:, 2] * volumes
            at = np.ravel_multi_index((base + (i, j, k)).T, self.shape)
            total += np.bincount(at, share, total.size)
            if values is not None:
                weighted += np.bincount(at, share * values, total.size)
        weighted, total = (gaussian_filter(sum_.reshape(self.shape), SMOOTHING) for sum_ in (weighted, total))
        self.values = np.divide(weighted, total, out=np.zeros_like(total), where=total > 0.0).astype(np.float32)
        lumps, _ = label(total > 0.5 * LEVEL * self.cell**3)
        small = np.bincount(lumps.ravel(), total.ravel()) < LUMP * spacing**3
        small[0] = False  # what is between the lumps
        self.density = np.where(small[lumps], 0.0, total / self.cell**3).astype(np.float32)
        self.near = maximum_filter(self.density, 2 * FAR + 1) > LEVEL  # elsewhere there is no snow within FAR cells
        self.smooth = gaussian_filter(self.density, SMOOTHING)  # for normals
        self.blurred = gaussian_filter(np.minimum(self.density, 1.0), 2.0)  # for the light that reaches a point from the sky

    def at(self, points, field="density"):
        """density, smooth, blurred or values at points."""
        return map_coordinates(getattr(self, field), ((points - self.low) / self.cell).T, order=1, mode="constant", prefilter=False)

    def normals(self, points):
        """Unit, out of the snow."""
        step = 0.75 * self.cell
        slope = np.stack([self.at(points + step * e, "smooth") - self.at(points - step * e, "smooth") for e in np.eye(3)], axis=1)
        return -slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-12)

    def hits(self, eye, rays, least, most):
        """Way along each ray to the surface; infinite where it passes by. @param least, most  part of each ray that is looked at"""
        low, high = self.low, self.low + self.cell * (np.array(self.shape) - 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (low - eye) / rays, (high - eye) / rays
        start = np.maximum(np.nanmax(np.minimum(a, b), axis=1), least)
        end = np.minimum(np.nanmin(np.maximum(a, b), axis=1), most)

        def probe(which, ways):
            points = eye[which] + ways[:, None] * rays[which]
            cells = np.clip(np.rint((points - self.low) / self.cell).astype(int), 0, np.array(self.shape) - 1)
            return self.at(points) > LEVEL, self.cell * np.where(self.near[tuple(cells.T)], 0.8, FAR - 1.0)  # minus the rounding to a cell

        return march(probe, start, end, 6)  # to a hundredth of a cell


def prism_hits(corners, base, top, eye, rays):
    """Way to a convex upright solid between two heights, and the normals there; infinite where a ray passes by.

    @param corners  (x, y), counter-clockwise from above
    """
    corners = np.asarray(corners, float)
    edges = np.roll(corners, -1, axis=0) - corners
    outward = np.column_stack([edges[:, 1], -edges[:, 0], np.zeros(len(edges))])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    faces = [*zip(outward, np.einsum("ij,ij->i", outward[:, :2], corners)), (np.array([0.0, 0.0, 1.0]), top), (np.array([0.0, 0.0, -1.0]), -base)]
    enter, leave, normals = np.full(len(rays), -np.inf), np.full(len(rays), np.inf), np.zeros((len(rays), 3))
    for normal, distance in faces:
        speed, gap = rays @ normal, distance - eye @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            way = gap / speed
        later = (speed < 0.0) & (way > enter)
        enter[later], normals[later] = way[later], normal
        leave = np.where(speed > 0.0, np.minimum(leave, way), leave)
        leave = np.where((speed == 0.0) & (gap < 0.0), -np.inf, leave)
    return np.where((enter < leave) & (enter > 0.0), enter, np.inf), normals


class Camera:
    """A pinhole camera. eye, target: m. angle: of the picture's height, degrees."""

    def __init__(self, eye, target, angle=32.0):
        self.eye, forward = np.asarray(eye, float), np.asarray(target, float) - eye
        self.forward = forward / np.linalg.norm(forward)
        self.right = np.cross(self.forward, [0.0, 0.0, 1.0])
        self.right /= np.linalg.norm(self.right)
        self.up, self.angle = np.cross(self.right, self.forward), np.radians(angle)

    def rays(self, width, height):
        """Unit directions through the pixels, row by row from above."""
        half = np.tan(0.5 * self.angle)
        y, x = np.meshgrid(half * (1.0 - 2.0 * (np.arange(height) + 0.5) / height),
                           half * width / height * (2.0 * (np.arange(width) + 0.5) / width - 1.0), indexing="ij")
        rays = self.forward + x[..., None] * self.right + y[..., None] * self.up
        return (rays / np.linalg.norm(rays, axis=2, keepdims=True)).reshape(-1, 3)

    def share_below(self, points):
        """Of points, that are below the lower edge of the picture or behind the camera."""
        way = points - self.eye
        return float(np.mean(way @ self.up < -np.tan(0.5 * self.angle) * (way @ self.forward)))


MOST_CUT = 0.01  # share of the particles that may lie below the lower edge of the picture
MOST_STEPS = 12  # back, by a tenth each


def standpoint(run, positions, top, ground=LevelGround()):
    """Camera, and mast and arm as [(corners, base, top), ...], for a run: from upstream, beside and above.

    @param top  of the snow in all pictures above the ground below it, m
    """
    low, high = positions.min(axis=0), positions.max(axis=0)
    if run.obstacle:
        centre = np.array([0.5 * run.obstacle_depth, 0.0, 0.45 * top])
        reach = max(1.45 * top, 0.5 * min(high[0] - low[0], 12.0 * (run.flow_height or top)), 3.0 * run.obstacle_width)
    else:
        centre = np.append(0.5 * (low + high)[:2], 0.35 * top)
        reach = max(1.2 * top, 0.55 * float(np.hypot(*(high - low)[:2])))
    base = ground.height(centre[None, :2])[0]
    centre[2] += base
    share = np.linspace(0.1, 1.0, 50)  # of the way from the centre to the eye: no hill may hide the snow
    for _ in range(MOST_STEPS):
        eye = centre + reach * np.array([-1.55, -1.45, 0.95])
        below = ground.height(centre[:2] + share[:, None] * (eye - centre)[:2])
        eye[2] = max(eye[2], np.max(centre[2] + (below - centre[2]) / share + 0.15 * reach))
        camera = Camera(eye, centre)
        if camera.share_below(positions) <= MOST_CUT:
            break
        reach *= 1.1  # the flow would be cut off at the lower edge
    return camera, run.solids(-1e4, base + 1.25 * top)


def nearest_hits(solids, eye, rays):
    """Way to the nearest of some solids, and the normals there, as prism_hits."""
    way, normals = np.full(len(rays), np.inf), np.zeros((len(rays), 3))
    for solid in solids:
        to_this, its_normals = prism_hits(*solid, eye, rays)
        nearer = to_this < way
        way[nearer], normals[nearer] = to_this[nearer], its_normals[nearer]
    return way, normals


def shadow(snow, solids, points, reach):
    """Share of the sun's light that reaches points: through the mast none, through the snow little.

    Uneven ground throws no shadow: the sun is 44 degrees high, and a case has no steeper ground (30 degrees against
    both axes are 39).
    """
    towards = np.broadcast_to(LIGHT, points.shape)
    lit = np.ones(len(points))
    lit[np.isfinite(nearest_hits(solids, points, towards)[0])] = 0.0
    way, step = 2.0 * snow.cell, 2.0 * snow.cell
    while way < reach:
        lit *= np.where(snow.at(points + way * LIGHT) > 0.5, 0.55, 1.0)
        way += step
    return lit


def draw(snow, camera, size, solids=(), colours=None, ground=LevelGround()):
    """The image, (height, width, 3) in 0 to 1.

    @param solids  (corners, base, top) of the mast and its arm
    @param colours  function of the values of SnowDensity to colours (count, 3); None: white snow
    """
    width, height = size
    rays = camera.rays(width, height)
    eye = np.broadcast_to(camera.eye, rays.shape)
    reach = 0.5 * float(np.max(np.array(snow.shape) * snow.cell))
    to_ground = ground.hits(eye, rays, SEEN * reach)
    to_solid, solid_normals = nearest_hits(solids, eye, rays)
    to_solid = np.where(to_solid < to_ground, to_solid, np.inf)
    to_snow = snow.hits(eye, rays, 0.0, np.minimum(to_ground, to_solid))
    share = np.clip(rays[:, 2:] * 2.5, 0.0, 1.0)
    image = SKY_LOW * (1.0 - share) + SKY_TOP * share
    for way, kind in ((to_ground, "ground"), (to_solid, "solid"), (to_snow, "snow")):
        seen = np.isfinite(way) & (way <= np.minimum(np.minimum(to_ground, to_solid), to_snow))
        if not seen.any():
            continue
        points = eye[seen] + way[seen, None] * rays[seen]
        normals = ground.normals(points) if kind == "ground" else solid_normals[seen] if kind == "solid" else snow.normals(points)
        base = {"ground": GROUND, "solid": MAST, "snow": SNOW}[kind]
        if kind == "snow" and colours:
            base = colours(snow.at(points - 0.5 * snow.cell * normals, "values"))
        sun = np.clip(normals @ LIGHT, 0.0, 1.0) * shadow(snow, solids, points + 0.5 * snow.cell * normals, reach)
        above, near = (snow.at(points + cells * snow.cell * normals, "blurred") for cells in (3.0, 1.5))
        open_sky = np.clip(1.35 - 1.1 * above - 0.5 * near, 0.25, 1.0)
        ambient = (0.31 + 0.13 * normals[:, 2]) * open_sky
        tint = np.array([0.92, 0.97, 1.06])  # of the sky's light
        light = 0.56 * sun[:, None] * np.array([1.03, 1.0, 0.95]) + ambient[:, None] * tint
        colour = base * light
        if kind == "ground":  # fades into the sky's low edge
            fade = np.clip(way[seen] / (6.0 * reach) - 0.3, 0.0, 1.0)[:, None]
            colour = colour * (1.0 - fade) + SKY_LOW * fade
        image[seen] = colour
    return np.clip(image, 0.0, 1.0).reshape(height, width, 3) ** (1.0 / 1.15)
