"""The presets of quality that artists know by name: tolerances, see `scene.Settings`."""

PRESETS = {"DRAFT": 5e-2, "PREVIEW": 1e-2, "FINAL": 1e-3}
