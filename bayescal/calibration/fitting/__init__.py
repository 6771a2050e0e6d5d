"""Least squares over a lens and all poses, from where to start to where it settles."""
