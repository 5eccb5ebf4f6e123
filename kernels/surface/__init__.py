"""The smooth water that a mesh samples: a finer surface with continuous slopes, from the vertices alone."""
