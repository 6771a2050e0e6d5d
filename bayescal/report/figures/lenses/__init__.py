"""Figures of lens models compared over many views."""
