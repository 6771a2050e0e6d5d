"""By what candidates are judged beside their evidence."""
