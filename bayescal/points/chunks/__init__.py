"""Points of any number: read in chunks, one pass, in memory that does not grow with them."""
