"""From Blender's dependency graph to the kernels' Scene: meshes, materials, lamps, receivers and their UV maps."""
