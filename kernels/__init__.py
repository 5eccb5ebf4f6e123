"""The light: pure numpy and embreex, no Blender.

Nothing in here imports ``bpy``, ``mathutils``, ``addon`` or ``operators``; only ``rays.py`` imports ``embreex``.
`methods` is the way in. The methods are `flat`, `sun_map`, `caustic_map`, `splat` (with `trace` over casters) and
`walk`; `plan` chooses, `surface` smooths water, `disc` blurs, `tile` repeats, `maps` holds texels, `chart` measures.
A path that fails is a status code, never an exception; a caller's mistake is a ``ValueError`` that names the argument
and its shape.

Symbols, used by every file of this folder (metres, world space, float64)
-------------------------------------------------------------------------
``eta``           n_water / n_air, 1.333 for water; ``r = 1 / eta``
``d``             unit direction in which the sun's light travels; ``s = -d`` points to the sun
``wi``, ``wo``    unit directions that point away from the surface
``n_g``, ``n_s``  geometric and shading normal
``cos_i``, ``cos_t``  cosines of incidence and refraction at the water
``M``, ``P``      a point on the water, a point on a receiver; ``u`` is the unit direction from M to P
``t``             unit direction of the refracted ray; ``tau`` the distance along it
``E``             irradiance [W/m^2]; ``phi`` radiant flux [W]
``T``             Fresnel transmittance, of unpolarised light
``sigma_a``       absorption coefficients [1/m], of red, green and blue
``error``         mean squared error over the mean square of the light, as tolerances and estimates count it; docstrings
                  say where it is over the squared mean instead
``texel``         one cell of a lightmap; image row 0 is at v = 0, as in Blender
"""
