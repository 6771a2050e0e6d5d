"""Is the recommended order adequate: what the residuals say against the model."""
