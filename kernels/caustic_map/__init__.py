"""Caustics mapping: a grid of points in the light's view, refracted, landed by look-ups and splatted."""
