"""What stands against a comparison of lenses: of the lenses, the bounds, the views."""
