"""How the parameters of every model of a run move together, as a table for other programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from math import isnan

from bayescal.comparison.faces.convert import Converts
from bayescal.inference.correlation import correlation_of

COVARIANCE = "covariance.csv"
COLUMNS = ("model", "parameter", "other", "covariance", "correlation")


def covariance_csv(models: Mapping[str, Converts]) -> str:
    """Write a row per pair of parameters of each model, every number in full.

    Parameters
    ----------
    models : mapping of str to Converts
        By their names in the run.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for model, found in models.items():
        names, matrix = found.named_covariance()
        rows = zip(names, matrix.tolist(), correlation_of(matrix).tolist(), strict=True)
        for name, values, correlations in rows:
            for other, value, rho in zip(names, values, correlations, strict=True):
                writer.writerow((model, name, other, repr(value), "" if isnan(rho) else repr(rho)))
    return text.getvalue()
