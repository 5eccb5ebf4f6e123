"""Lightmaps on the receivers: attached to materials, taken off again, and shown live."""
