"""The chart of a scene: measured, drawn, and written beside the maps."""
