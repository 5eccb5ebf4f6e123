"""What Blender does: reads the scene, runs the kernels frame by frame, writes images and the record of the bake.

`read` makes a Scene of what Blender evaluates, `bake` runs its frames in worker processes, `maps` writes and exports,
`show` puts maps on materials, `chart` measures the methods, `buttons` are Blender's operators.

Imports kernels; never imports addon. Holds no maths of light.
"""
