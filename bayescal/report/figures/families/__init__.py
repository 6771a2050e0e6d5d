"""Figures of a comparison across families."""
