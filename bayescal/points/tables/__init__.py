"""Tables that people write: read within bounds, taken apart, their columns named."""
