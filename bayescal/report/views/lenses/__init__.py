"""Lens models over many views as people see them."""
