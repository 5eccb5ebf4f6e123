"""What Blender does: reads the scene, runs the kernels frame by frame, writes images and the record of the bake.

Imports kernels; never imports addon. Holds no maths of light.
"""
