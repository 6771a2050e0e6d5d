"""Figures of an analysis of bad points."""
