"""Correspondences and the camera's setup: what is measured and what is known."""
