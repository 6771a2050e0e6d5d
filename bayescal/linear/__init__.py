"""Linear Gaussian models: least squares, evidence and posterior in closed form."""
