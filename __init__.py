"""Dapple bakes the caustics of animated water into per-frame lightmaps for EEVEE.

Importing this package imports nothing else, so that `kernels` works where there is no Blender.
"""


def register():
    """Add Dapple's properties, operators and panels to Blender."""
    from . import addon

    addon.register()


def unregister():
    """Take away what `register` added."""
    from . import addon

    addon.unregister()
