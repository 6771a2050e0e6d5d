"""Lens models compared over many views of a target."""
