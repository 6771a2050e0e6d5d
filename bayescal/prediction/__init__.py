"""The calibrated camera at work: where points appear, what pixels look at, and how sure that is."""
