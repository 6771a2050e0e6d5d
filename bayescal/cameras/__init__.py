"""The camera: lenses, pose and projection."""
