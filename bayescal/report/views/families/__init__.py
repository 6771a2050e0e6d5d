"""A comparison across families: its tables, its words and the view made of them."""
