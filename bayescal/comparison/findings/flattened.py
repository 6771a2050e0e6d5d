"""Errors of the world coordinates that flatten the curve by a part of its standard error."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.finding import Finding, limits
from bayescal.comparison.findings.case import Case
from bayescal.linear.errors.attenuation import attenuation
from bayescal.noise.world_errors import WorldErrors
from bayescal.rounding import significant

# Standard errors of the curve: at 0.33 intervals of 95 % of an order 4 held in 88 % of cases
# (docs/validation.md, errors of the world coordinates).
WORTH_SAYING = 0.3


def flattened(case: Case) -> Iterator[Finding]:
    """Say what errors of the world coordinates take of the best order's curve, where it matters."""
    data, best = case.axis.data, case.best
    if data.x_sd is None or not data.x_sd.any():
        return
    found = attenuation(data, _deviations(case), best.fit.amplitudes)
    if found.standard_errors > WORTH_SAYING:
        yield limits(
            "world-errors",
            f"errors of the world coordinates flatten the curve: order {best.order} is off by "
            f"about {significant(abs(found.shift))} px at {data.regressor} = {found.place:.3g}, "
            f"{significant(found.standard_errors)} of its standard errors there, so that its 95% "
            "intervals may hold less often",
        )


def _deviations(case: Case) -> Array:
    """Deviations of residuals, errors of the world among them, ``(n_points,)``, px."""
    data, level = case.axis.data, case.axis.noise
    posterior = case.best.posterior
    value = 1.0
    if level.bounds is not None:
        value = next(p.mean for p in posterior.parameters if p.name == level.parameter)
    own = value * data.deviations
    if not isinstance(case.shape, WorldErrors):
        return own
    return np.asarray(np.sqrt(own**2 + case.shape.carried(np.array([math.log(value)]))[0]))
