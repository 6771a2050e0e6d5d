"""Figures of a calibrated camera: maps over the image."""
