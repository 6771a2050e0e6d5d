"""Photographs of a target: where its points are, found by OpenCV."""
