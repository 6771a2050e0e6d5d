"""Noise: its level, and the models of its shape about that level."""
