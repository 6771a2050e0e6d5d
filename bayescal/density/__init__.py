"""Densities that are sampled: built of a camera or a polynomial, a prior and noise."""
