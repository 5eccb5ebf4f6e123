"""Cycles' shadow caustics on a Scene: baked light on its receivers, at several numbers of samples.

Run by `peers.py`. The Scene becomes a Blender scene of its own: the water and glass cast shadow caustics (manifold
next-event estimation), the receivers take them, and what comes straight from the sun is taken off again, by a second
bake in which nothing casts them. What Cycles says of light in water is 1 / eta^2 of the irradiance, to four digits on
still water under any slanted sun, since it leaves the eta^2 of radiance out on both ways through the surface: here it
is put back, so that what is compared is how much of the light is found.
"""

from __future__ import annotations

import time

import bpy
import numpy as np

SAMPLES, STRAIGHT = (1, 4, 16, 64), 16
_DARK = 1e-3
_PATIENCE = 3.0  # CPU s of a bake: none with more samples follows


def runs(scene, texels):
    """Yield the runs of Cycles on a Scene; raises ValueError for lamps that it is not handed."""
    from bench.peers import run_of

    from dapple.kernels.chart.maps import light_of
    from dapple.kernels.scene import Sun

    if not all(isinstance(light, Sun) for light in scene.lights):
        raise ValueError("it is handed suns only")
    stage = Stage(scene, [own.resolution for own in texels])
    straight, _ = stage.bake(STRAIGHT, casting=False)
    stage.bake(1, casting=True)  # warm
    radiance = scene.eta**2 if len(scene.water.triangles) else 1.0
    for samples in SAMPLES:
        images, seconds = stage.bake(samples, casting=True)
        light = radiance * (light_of(texels, images) - light_of(texels, straight))
        yield run_of("Cycles, shadow caustics", f"{samples} sample{'s' * (samples > 1)}", seconds, light)
        if seconds > _PATIENCE:
            return


class Stage:
    """The Scene in Blender, ready to be baked."""

    def __init__(self, scene, resolutions):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.receivers, self.casters = [], []
        for receiver, resolution in zip(scene.receivers, resolutions, strict=True):
            made = _object(receiver, _dark(receiver.name, resolution))
            uvs = made.data.uv_layers.new(name="UVMap")
            uvs.data.foreach_set("uv", np.asarray(receiver.uvs, np.float32).ravel())
            made.cycles.is_caustics_receiver = True
            self.receivers.append(made)
        for occluder in scene.occluders:
            _object(occluder, _material("black", "ShaderNodeBsdfDiffuse", Color=(0, 0, 0, 1)))
        if len(scene.water.triangles):
            water = _material("water", "ShaderNodeBsdfGlass", IOR=float(scene.eta), Roughness=0.0)
            self.casters.append(_object(scene.water, water, scene.water))
        for caster in scene.casters:
            self.casters.append(_object(caster, _bending(caster.material), caster))
        for light in scene.lights:
            _sun(light)
        _set_up()

    def bake(self, samples, casting):
        """Images (R,R,3) [W/m^2], one a receiver, and CPU seconds."""
        cycles = bpy.context.scene.cycles
        cycles.samples, cycles.caustics_refractive = samples, casting  # without the second nothing is cast
        for caster in self.casters:
            caster.cycles.is_caustics_caster = casting
            caster.update_tag()
        for receiver in self.receivers:
            receiver.select_set(True)
        bpy.context.view_layer.objects.active = self.receivers[0]
        start = time.process_time()
        bpy.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT", "INDIRECT"}, margin=0, use_clear=True)
        seconds = time.process_time() - start
        return [_pixels(receiver) * np.pi for receiver in self.receivers], seconds


def _set_up():
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = "CPU", False, False
    scene.cycles.light_sampling_threshold = 0.0
    # Caustics count as light of one diffuse bounce.
    scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = 1
    scene.cycles.caustics_reflective = False
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.world = None  # a new one is grey


def _object(mesh, material, shaded=None):
    """An object of a mesh of arrays; with the normals of `shaded`, as seen."""
    data = bpy.data.meshes.new(mesh.name)
    data.vertices.add(len(mesh.positions))
    data.vertices.foreach_set("co", np.asarray(mesh.positions, np.float32).ravel())
    data.loops.add(mesh.triangles.size)
    data.loops.foreach_set("vertex_index", np.asarray(mesh.triangles, np.int32).ravel())
    data.polygons.add(len(mesh.triangles))
    data.polygons.foreach_set("loop_start", np.arange(0, mesh.triangles.size, 3, dtype=np.int32))
    data.update(calc_edges=True)
    if shaded is not None:
        data.polygons.foreach_set("use_smooth", np.ones(len(data.polygons), bool))
        data.normals_split_custom_set(shaded.normals[shaded.normal_triangles].reshape(-1, 3).tolist())
    data.materials.append(material)
    made = bpy.data.objects.new(mesh.name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


def _material(name, kind, **values):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, end = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    for key, value in values.items():
        shader.inputs[key].default_value = value
    tree.links.new(shader.outputs[0], end.inputs["Surface"])
    return material


def _dark(name, resolution):
    """Matt, with the image that it is baked to, which is over its colour; dark, so that receivers light none else."""
    material = _material(name, "ShaderNodeBsdfDiffuse", Color=(_DARK, _DARK, _DARK, 1))
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = bpy.data.images.new(name, resolution, resolution, float_buffer=True, is_data=True)
    material.node_tree.nodes.active = node
    return material


def _bending(material):
    """Glass or a mirror."""
    if hasattr(material, "eta"):
        return _material("glass", "ShaderNodeBsdfGlass", IOR=float(np.mean(material.eta)), Roughness=0.0)
    return _material("mirror", "ShaderNodeBsdfGlossy", Roughness=0.0, Color=(*map(float, material.f0), 1))


def _sun(light):
    from mathutils import Vector

    data = bpy.data.lights.new(light.name, "SUN")
    data.energy = float(light.irradiance.max())
    data.color = light.irradiance / light.irradiance.max()
    data.angle, data.cycles.is_caustics_light = light.angle, True
    made = bpy.data.objects.new(light.name, data)
    made.rotation_euler = Vector(light.direction).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(made)


def _pixels(receiver):
    nodes = receiver.data.materials[0].node_tree.nodes
    image = nodes.active.image
    flat = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(flat)
    return flat.reshape(image.size[1], image.size[0], 4)[..., :3].astype(float)


if __name__ == "__main__":
    from bench_stages import load_dapple

    load_dapple()
    from bench.peers import answer

    answer(runs)
