"""Joint candidates of r and c: what each is, and how it is judged."""
