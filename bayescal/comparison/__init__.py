"""Which order, how strongly, and by which criteria."""
