"""Points that may be bad: lenses weighed over sets of them, and how they are named."""
