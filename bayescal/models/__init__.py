"""What predicts a pixel and with what likelihood: bases, families, noise, priors."""
