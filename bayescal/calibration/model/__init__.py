"""What views, lenses and error models are: arrays, parameters, priors."""
