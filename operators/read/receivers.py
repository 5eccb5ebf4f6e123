"""Which meshes take the light, and in which map: one for each object or instance, or one that several share."""

from __future__ import annotations

import numpy as np

from ...kernels.scene import Receiver
from ..errors import DappleError
from .find import shows_collection
from .tiles import tile_name

_FLAT, _NOTHING = 1e-3, 1e-15  # of the area that is worth a word; an area that is none
_EDGE = 1e-5  # by how much UVs, of float32, may leave their tile
_FILL = 0x7FFFFFFF  # of the unused numbers of a persistent_id


def can_receive(obj) -> bool:
    """Whether an object can be chosen as a receiver: a mesh, or an Empty that shows a collection."""
    return obj.type == "MESH" or shows_collection(obj)


def map_name(obj) -> str:
    """The name of the map that an object's light is kept in: its own name, or what its settings say."""
    return obj.dapple.shared_map.strip() or obj.name


def instance_name(instance) -> str:
    """A name for an instance that stays the same from frame to frame: of what shows it, of what is shown, a number."""
    number = ".".join(str(n) for n in instance.persistent_id if n != _FILL)
    return f"{instance.parent.original.name} {instance.object.original.name} {number}"


def shows_receivers(instance) -> bool:
    """Whether an instance of a receiver is one as well: of an Empty always, of a mesh where its settings ask for it."""
    parent = instance.parent.original
    return instance.object.type == "MESH" and (parent.type != "MESH" or parent.dapple.instances_receive)


class Maps:
    """The meshes that take light in one frame, by their maps."""

    def __init__(self):
        self.owners, self._parts, self._shared = set(), {}, {}

    def add(self, owner, name, arrays, uvs):
        """Add a mesh of world space, MeshArrays and its UVs (T,3,2), of the receiver `owner` to the map `name`."""
        self.owners.add(owner)
        self._parts.setdefault(name, []).append((arrays.positions, arrays.triangles, uvs))

    def add_instance(self, instance, matrix, read):
        """Add an instance under a world matrix (4,4); read: gives MeshArrays and UVs of an evaluated object in its own
        space, and is asked once for each mesh."""
        shown, owner = instance.object, instance.parent.original
        key = shown.data.as_pointer()
        if key not in self._shared:
            self._shared[key] = read(shown)
        arrays, uvs = self._shared[key]
        self.owners.add(owner.name)
        name = owner.dapple.shared_map.strip() or instance_name(instance)
        turn = -1 if np.linalg.det(matrix[:3, :3]) < 0 else 1  # mirrored: wound to agree with their normals again
        positions = arrays.positions @ matrix[:3, :3].T + matrix[:3, 3]
        if not np.isfinite(positions).all():
            raise DappleError(f"Receiver '{name}' has coordinates that are not numbers; check the instances.")
        self._parts.setdefault(name, []).append((positions, arrays.triangles[:, ::turn], uvs[:, ::turn]))

    def receivers(self):
        """The Receivers, one for each map, in the order of the names."""
        joined = ((name, _joined(parts)) for name, parts in sorted(self._parts.items()))
        return tuple(Receiver(*tile) for name, mesh in joined for tile in _tiles(name, *mesh))


def _tiles(name, positions, triangles, uvs):
    """(name, positions, triangles, uvs in 0..1) of each UDIM tile that UVs (T,3,2) lie in: a map each. All as it is
    where that is the first tile only, or where a triangle lies in no single tile, which the rasteriser tells."""
    tile = np.floor(uvs.mean(1) if len(uvs) else np.zeros((0, 2)))
    inside = np.abs(uvs - tile[:, None] - 0.5) <= 0.5 + _EDGE
    sound = np.isfinite(uvs).all() and inside.all() and (tile >= 0).all() and (tile[:, 0] <= 9).all()
    if not sound or not tile.any():
        yield name, positions, triangles, uvs
        return
    for u, v in np.unique(tile, axis=0).astype(int):
        own = (tile == (u, v)).all(1)
        yield tile_name(name, 1001 + u + 10 * v), positions, triangles[own], np.clip(uvs[own] - (u, v), 0, 1)


def flat_parts(receivers):
    """Sentences on Receivers of whose area a part has none in the UV map."""
    said = []
    for receiver in receivers:
        v = receiver.positions[receiver.triangles]
        area = np.linalg.norm(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]), axis=1)
        u, w = receiver.uvs[:, 1] - receiver.uvs[:, 0], receiver.uvs[:, 2] - receiver.uvs[:, 0]
        lost = area[np.abs(u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]) <= _NOTHING].sum() / max(area.sum(), _NOTHING)
        if _FLAT < lost < 1:
            said.append(
                f"{lost:.1%} of the area of receiver '{receiver.name}' has no area in its UV map: light there is lost. "
                "Unwrap it, or press Make Lightmap UVs."
            )
    return said


def _joined(parts):
    """Positions, triangles and UVs of meshes as of one."""
    positions, triangles, uvs = zip(*parts, strict=True)
    base = np.cumsum([0, *(len(p) for p in positions)])
    triangles = [t + start for t, start in zip(triangles, base, strict=False)]
    return np.concatenate(positions), np.concatenate(triangles), np.concatenate(uvs)
