"""Error against time of every method on a scene."""
