"""The nodes that read baked maps: one image sequence, or one for each UDIM tile that a receiver's UVs lie in.

Blender plays an image sequence or shows a tiled image, but plays no tiled sequence: so each tile is an image of its
own, taken where the UV map lies in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy

TAG = "dapple"
TILE, SCALE = "dapple_tile", "dapple_scale"  # on an image texture: what its nodes were made for


@dataclass(frozen=True)
class Sequence:
    """A baked map: the image, its first and last frame; scale: the irradiance that its value 1 stands for [W/m^2];
    tile: the UDIM tile that it is for, None for all of the UV map."""

    image: bpy.types.Image
    first: int
    last: int
    scale: float = 1.0
    tile: int | None = None


def update(tree: bpy.types.NodeTree, sequences: tuple[Sequence, ...]) -> bool:
    """Let the nodes that `add` added read `sequences`, and leave all else as it is; False, with nothing changed, where
    they were made for other tiles or another scale."""
    textures = [node for node in tree.nodes if TAG in node and node.bl_idname == "ShaderNodeTexImage"]
    made = {(node.get(TILE), node.get(SCALE, 1.0)) for node in textures}
    if textures and made != {(sequence.tile, sequence.scale) for sequence in sequences}:
        return False
    by_tile = {sequence.tile: sequence for sequence in sequences}
    for node in textures:
        _read(node, by_tile[node.get(TILE)])
    return True


def map_socket(tree, sequences, uv_map, frame, location):
    """Make the nodes that read Sequences by the UV map that was baked; return the light's colour output."""
    x, y = location
    uv = new(tree, "ShaderNodeUVMap", frame, (x - 400, y), "UV Map")
    uv.uv_map = uv_map
    light = _texture(tree, sequences[0], uv.outputs["UV"], frame, (x, y))
    if len(sequences) == 1:
        return light
    # Which tile: the first everywhere, and each other one where it is. No clipping: it would darken the tiles' borders.
    cell = _vector(tree, "FLOOR", frame, (x - 200, y + 150), "Tile of UV", uv.outputs["UV"])
    for k, sequence in enumerate(sequences[1:], 1):
        place = (x, y - 300 * k)
        here = _texture(tree, sequence, uv.outputs["UV"], frame, place)
        apart = _vector(tree, "DISTANCE", frame, (x - 200, place[1] + 150), "Tiles Apart", cell.outputs[0])
        apart.inputs[1].default_value = _corner(sequence.tile)
        inside = new(tree, "ShaderNodeMath", frame, (x, place[1] + 150), "Is Inside")
        inside.operation, inside.inputs[1].default_value = "LESS_THAN", 0.5
        tree.links.new(apart.outputs["Value"], inside.inputs[0])
        light = _mixed(tree, inside.outputs[0], light, here, frame, (x + 170, place[1] + 150))
    return light


def _texture(tree, sequence, uv, frame, location):
    """Make the nodes that read one map at a UV output of the whole map; return its colour output."""
    x, y = location
    texture = new(tree, "ShaderNodeTexImage", frame, (x, y), "Irradiance")
    texture.extension = "EXTEND"
    texture.interpolation = "Linear"
    _read(texture, sequence)
    if sequence.tile is not None:
        texture[TILE] = sequence.tile
        moved = _vector(tree, "SUBTRACT", frame, (x - 200, y), "UV in Tile", uv)
        moved.inputs[1].default_value = _corner(sequence.tile)
        uv = moved.outputs[0]
    tree.links.new(uv, texture.inputs["Vector"])
    if sequence.scale == 1.0:
        return texture.outputs["Color"]
    texture[SCALE] = sequence.scale
    scaled = _vector(tree, "SCALE", frame, (x + 150, y - 150), "Scale", texture.outputs["Color"])
    scaled.inputs["Scale"].default_value = sequence.scale
    return scaled.outputs[0]


def _corner(tile):
    """Where the lower left corner of a UDIM tile lies in the UV map."""
    row, column = divmod(tile - 1001, 10)
    return column, row, 0


def _vector(tree, operation, frame, location, name, source):
    """Make a Vector Math node that takes `source` first."""
    node = new(tree, "ShaderNodeVectorMath", frame, location, name)
    node.operation = operation
    tree.links.new(source, node.inputs[0])
    return node


def _mixed(tree, share, first, second, frame, location):
    """Make the node that goes from `first` to `second` by a share; return its output."""
    node = new(tree, "ShaderNodeMix", frame, location, "Tile")
    node.data_type = "VECTOR"
    sockets = {socket.identifier: socket for socket in node.inputs}
    for socket, source in (("Factor_Float", share), ("A_Vector", first), ("B_Vector", second)):
        tree.links.new(source, sockets[socket])
    return next(socket for socket in node.outputs if socket.identifier == "Result_Vector")


def _read(texture, sequence):
    """Set which files an image texture reads at which frame."""
    texture.image, user = sequence.image, texture.image_user
    # The file's number is frame - frame_start + 1 + frame_offset. Cyclic, for outside of the range a sequence is
    # magenta otherwise.
    user.frame_start, user.frame_offset = sequence.first, sequence.first - 1
    user.frame_duration = sequence.last - sequence.first + 1
    user.use_cyclic = user.use_auto_refresh = True


def new(tree, kind, frame, location, name):
    """Make a node of ours in a frame."""
    node = tree.nodes.new(kind)
    node.name, node[TAG], node.parent, node.location = f"Dapple {name}", True, frame, location
    return node
