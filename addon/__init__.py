"""What Blender sees: registration, properties, panels."""

from .registration import register, unregister

__all__ = ["register", "unregister"]
