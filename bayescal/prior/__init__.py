"""Priors: of amplitudes in pixels, of the camera, of scales."""
