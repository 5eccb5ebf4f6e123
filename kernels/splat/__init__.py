"""Forward, from the water: photons as beams and as points, and where they land."""
