"""Still water: the closed form, and what waves would add to it."""
