"""Figures of a comparison of orders."""
