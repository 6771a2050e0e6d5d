"""From a model and data to a posterior: least squares, closed form, sampling, diagnostics."""
