"""An analysis of bad points as people see it."""
