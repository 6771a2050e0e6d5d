"""The answers to a referee: prior, other points, other noise, other orders."""
