"""The calibrated camera: its models, where they come from, and how it is kept."""
