"""Regressors, bases and nested polynomial families: what a linear model of a pixel is made of."""
