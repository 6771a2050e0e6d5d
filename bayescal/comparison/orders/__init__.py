"""The orders of one axis as candidates, and what their list says together."""
