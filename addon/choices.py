"""What the settings can be set to: (identifier, name, description) of each choice."""

METHODS = (
    (
        "auto",
        "Automatic",
        "Plan each frame: the quickest method that is predicted to meet the tolerance. bake.json says which and why",
    ),
    (
        "flat",
        "Still Water",
        "The light as if the water lay still, at once: right where waves are so low for the depth that no lines show. "
        "bake.json says how much light the waves would have moved",
    ),
    (
        "sun_map",
        "Sun Map (a Look)",
        "A look of caustics, not the light: lines by the water's slope straight above each texel, where the true ones "
        "are not. For a first impression, and for pictures that need not be right",
    ),
    (
        "caustic_map",
        "Caustic Map",
        "Splat the light as points, as games do: soft lines, no finer than the points. For glass it takes two surfaces "
        "and guesses the second, quickly. Light Sheet is sharper, and for water quicker as well",
    ),
    (
        "photon_splat",
        "Light Sheet",
        "Follow the light from the water down and share every beam among the texels that it covers. "
        "Finds all of the light and is quick: right for most scenes",
    ),
    (
        "conic_walk",
        "Path Search",
        "Start at the texels and find every way that light takes through the water to each, exactly. Slower, and "
        "without reflection and glass: for close-ups, and to check the other methods",
    ),
)

SURFACES = (
    (
        "auto",
        "Automatic",
        "Where the water is shaded smooth, take the smooth surface that its vertices lie on in place of its facets: "
        "the light is far more exact, and lines along edges vanish. Flat and custom normals stay",
    ),
    ("mesh", "Mesh", "Take the mesh as it is, with its normals"),
)

DEPTHS = (
    ("HALF", "Float (Half)", "16 bits a channel, exact to one part in 2000: right for nearly all uses"),
    ("FULL", "Float (Full)", "32 bits a channel: several times larger files"),
)

QUALITIES = (
    ("DRAFT", "Draft", "Tolerance 0.05: for trying things out"),
    ("PREVIEW", "Preview", "Tolerance 0.01: clean to the eye"),
    ("FINAL", "Final", "Tolerance 0.001: for close-ups and measurements"),
    ("CUSTOM", "Custom", "The tolerance is none of the presets"),
)

# In the order of operators.read.volume.FACES.
CULLING = (
    ("-X", "-X", "Light that leaves by side -X ends there", 1),
    ("+X", "+X", "Light that leaves by side +X ends there", 2),
    ("-Y", "-Y", "Light that leaves by side -Y ends there", 4),
    ("+Y", "+Y", "Light that leaves by side +Y ends there", 8),
    ("-Z", "-Z", "Light that leaves by side -Z ends there", 16),
    ("+Z", "+Z", "Light that leaves by side +Z ends there", 32),
)

CAUSTICS = (
    (
        "AUTO",
        "Automatic",
        "Cast where a material refracts or mirrors and is smooth, or where Cycles' Cast Shadow Caustics is on",
    ),
    ("ALWAYS", "Casts", "Take every material that refracts or mirrors as smooth, however rough it is"),
    ("NEVER", "Blocks", "Cast no caustics, only a shadow"),
    ("WATER", "Is Water", "Bend light as the water does, together with it: for several waters at once"),
)
