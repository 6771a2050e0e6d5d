"""Samples, weighs and climbs any density, and checks what it has drawn."""
