"""Backward, from the texels: the conic walk, manifold next-event estimation along the coplanarity curve."""
