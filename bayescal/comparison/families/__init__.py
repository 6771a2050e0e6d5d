"""Families of models of r and c together: built, sampled or weighed, and judged."""
