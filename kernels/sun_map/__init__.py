"""The sun map: a look of caustics by one vertical ray and one look-up per texel."""
