"""Noise: its level, and the models of its shape about that level."""

# By the names users know them by: a new one is one module here, with its NOISE, and one name, the
# last (their places are part of the random numbers' seeds).
NAMES = ("gaussian", "student-t", "outlier-mixture")
