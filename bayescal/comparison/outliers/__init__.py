"""Bad points: rejection, records of points, and whether they choose the order."""
