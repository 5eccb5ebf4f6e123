"""Lightmaps as grids: charts of UV maps, exact area coverage, and the texels that a receiver owns."""
