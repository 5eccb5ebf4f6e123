"""The lamp's disc: what a sun that is not a point does to the light on the receivers."""
