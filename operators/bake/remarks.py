"""What a frame's maps cannot be, and what is worth a warning once they are there."""

from __future__ import annotations

import numpy as np

from ..errors import DappleError
from ..maps.write import map_path

LEAST_RESOLUTION, MOST_RESOLUTION = 16, 16384
_NO_LIGHT = (
    "No light by way of water, glass or mirrors reaches receiver '{}'; check that one of them lies between the lamps "
    "and it, or that it stands where they mirror the lamps."
)
_BACKS = (
    "{:.0%} of the light that comes to receivers falls on the backs of their faces, which stay dark. Turn the "
    "faces round (Edit Mode: Mesh > Normals > Flip), or give a wall that is lit on both sides a thickness."
)
_SLOW = (
    "Rays are traced by numpy, some twenty times slower, for {}. Reinstall the extension for this system, or use a "
    "Blender from blender.org; the maps are the same."
)
_MUCH = 0.5  # of the light on receivers


def check_maps(names, sizes):
    """Raise DappleError for maps of these names and sizes that cannot all be kept."""
    texels = sum(size**2 for size in sizes)
    if texels > MOST_RESOLUTION**2:
        most = int(MOST_RESOLUTION / len(names) ** 0.5)
        if min(sizes) < max(sizes):
            percent = int(100 * MOST_RESOLUTION / texels**0.5)
            raise DappleError(
                f"{len(names)} maps of {max(sizes)} texels and less do not fit into memory; set {percent} % of the "
                "texels per metre."
            )
        raise DappleError(f"{len(names)} maps of {max(sizes)} texels do not fit into memory; set {most} at most.")
    folders = {}
    for name in names:
        other = folders.setdefault(map_path("", name, 0).as_posix().casefold(), name)
        if other != name:
            raise DappleError(f"Receivers '{other}' and '{name}' would share a folder on some systems; rename one.")


def remarks(diagnostics):
    """Warnings on receivers that stay dark, and on slow rays."""
    received = diagnostics.flux_received
    warnings = [_NO_LIGHT.format(name) for name, flux in received.items() if not flux.any()]
    back = np.sum(diagnostics.flux_lost.get("back", 0.0))
    total = back + sum(flux.sum() for flux in received.values())
    if back > _MUCH * total:
        warnings.append(_BACKS.format(back / total))
    if diagnostics.slow_rays:
        warnings.append(_SLOW.format(diagnostics.slow_rays))
    return warnings
