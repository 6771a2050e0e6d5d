"""Errors of the regressor: what they add to the noise, and what they take of a curve."""
