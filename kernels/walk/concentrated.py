"""Light that the water throws together: beams for the triangles that do so.

Where the image of a triangle shrinks, to a line on a fold, sub-points meet it ever more rarely and find ever more light
when they do: their mean has no finite variance. So the light of such triangles is shared among the texels by the area
that their images cover (`splat/beams.py`), and paths at sub-points count the others', whose light is nowhere much
denser than what comes in.
"""

from __future__ import annotations

import numpy as np

from ..lit_water import part_of
from ..rays import soup
from ..scene import Spot
from ..splat.beams import splat
from ..splat.edges import Edges
from ..splat.lander import Lander
from ..splat.plane import PlaneLander, one_plane
from ..splat.sheet import Sheet
from ..splat.silhouettes import Silhouettes

LEFT_OUT = ["objects less than a texel wide as the light sees them count in part where light is thrown together"]
_DENSE = 1.25  # times the light's density as it comes in, or its mean on the receivers where that is less
_TRIANGLES = 1 << 12  # at once
_SIGHT = 1.0  # texels: how wide a thing may stand between rays unseen


def focusing(grid, triangles, area):
    """Whether (m,) triangles, with area (m,) across the light, throw it together, somewhere in the depths of a
    Grid and beside its points."""
    least = np.full(len(triangles), np.inf)
    light = image_area = 0.0
    for start in range(0, len(triangles), _TRIANGLES):
        block = slice(start, start + _TRIANGLES)
        lines = grid.lines(*grid.rays.corner[triangles[block]].T, *grid.rays.middle[triangles[block]].T)
        for layer in range(grid.layers):
            images = grid.images(lines, layer)
            some = np.zeros(len(lines[0][0]), bool)
            some[grid.near(images, layer, cells=1)[0]] = True  # texels reach beyond their centres
            near = np.flatnonzero(some)
            for image in images:
                jacobian = image.jacobian()
                low, high = np.minimum.reduce(jacobian)[near], np.maximum.reduce(jacobian)[near]
                here = np.where(low * high > 0, np.minimum(np.abs(low), np.abs(high)), 0)
                least[start + near] = np.minimum(least[start + near], here)
                light += 2 * area[start + near].sum()
                image_area += np.abs(image.area[near]).sum()
    return least * _DENSE * min(light / max(image_area, np.finfo(float).tiny), 1.0) < 2 * area


def throw_together(scene, texels, objects, paths, chosen, tolerance):
    """Flux (K,3) [W] that triangles chosen (T,) bool of LightPaths send to the Texels of a Scene's receivers, and its
    predicted relative mean squared error, which is to be within the tolerance; objects: a Tracer over the receivers and
    all that occludes."""
    owned = np.zeros((sum(len(t.texel) for t in texels), 3))
    if not chosen.any():
        return owned, 0.0
    water, twins = part_of(paths.lit, scene.water.twins, chosen)
    lander = _lander(scene, texels, objects, paths, chosen)
    sheet = Sheet(lander.image, len(texels), texels[0].resolution, lander.rows.count)
    area = np.concatenate([t.area for t in texels])
    mean = min(paths.lit.light() / area.sum(), 1.0)
    square = len(area) * mean**2
    texel_area = [t.area.sum() / len(t.area) for t in texels]
    shadowed = paths.in_shadow[chosen]
    edges = Edges.of(water.triangles, twins, np.array_equal(water.triangles, water.normal_triangles))
    *_, error = splat(water, edges, lander, shadowed, sheet, texel_area, tolerance * square, _SIGHT)
    flux = sheet.flux()
    for k, channel in enumerate(lander.rows.channel):
        parts = np.split(flux[channel], len(texels))
        owned[:, k] = np.concatenate([t.gather(part)[0] for t, part in zip(texels, parts, strict=True)])
    return owned * water.source.power, error / square


def _lander(scene, texels, objects, paths, chosen):
    """What lands the rays of triangles chosen (T,): in closed form where nothing can stand in their way."""
    medium = paths.lit.source, scene.eta, np.asarray(scene.sigma_a, float)
    plain = not (paths.in_shadow[chosen].any() or isinstance(paths.light, Spot))  # the rim of a cone needs rays
    plane = one_plane(scene, texels) if plain else None
    if plane is not None:
        return PlaneLander(plane, texels[0].chart, *medium, paths.fresnel)
    outlines = Silhouettes(*soup((*scene.receivers, *scene.occluders, *scene.casters)))
    return Lander(scene.receivers, texels, objects, outlines, None, *medium, fresnel=paths.fresnel)
