"""Lightmaps as files: written whole, read back, and exported as loops, PNG, atlases and cookies."""
