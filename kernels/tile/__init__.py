"""Light under water that repeats in both directions, as one tile that repeats."""
