"""Pinholes as densities: fitted, approximated, and sampled under any noise."""
