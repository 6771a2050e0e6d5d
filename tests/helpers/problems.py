"""Problems the tests share: models of the thesis data and of generated points."""

from __future__ import annotations

import numpy as np

import bayescal as bc
from bayescal.linear.least_squares import factorise
from bayescal.linear.model import LinearModel
from bayescal.noise.level import NoiseLevel
from bayescal.points.setup import StatedPrior
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.separable import axis_data
from bayescal.prior.amplitudes import CoefficientPrior, PriorRule

AXES = ("r", "c")
ORDERS = (1, 2, 3, 4, 5)
THESIS_MODELS = [(axis, order) for axis in AXES for order in ORDERS]

# A stated prior that the data and the prior both bear on, for the r axis: its means
# are off by about one deviation, and its deviations are of the size of the posterior's.
STATED_R = StatedPrior((960.0, 1190.0, 8.0, -30.0, 11.0, 0.0), (2.0, 3.0, 4.0, 5.0, 6.0, 7.0))


def thesis_axis(axis: str) -> AxisData:
    """One axis of the thesis data."""
    return axis_data(bc.thesis(), axis)


def make_axis(x, t, size=1000.0, sd=None) -> AxisData:
    """An axis of given points, on an image of known size."""
    x, t = np.asarray(x, dtype=float), np.asarray(t, dtype=float)
    sd = None if sd is None else np.asarray(sd, dtype=float)
    labels = tuple(str(i) for i in range(len(x)))
    return AxisData("r", "x/z", "alpha", x, t, sd, labels, float(size), True, "generated")


def field_rule(data: AxisData, tau: float | None = None) -> PriorRule:
    """The default prior of an axis of known image size."""
    return PriorRule("field", data.size, data.size / 2, tau)


def make_model(
    data: AxisData,
    order: int,
    *,
    sigma: float | None = None,
    bounds: tuple[float, float] | None = None,
    prior: str = "field",
    tau: float | None = None,
    stated: StatedPrior | None = None,
    scale: bool = False,
    pixel: float = 1.0,
) -> LinearModel:
    """A likelihood model; sigma is inferred unless it is given or known per point.

    With `scale` a factor on the points' known deviations is inferred. An inferred tau begins at a
    hundredth of `pixel`.
    """
    if data.sd is not None:
        noise = NoiseLevel.scale() if scale else NoiseLevel.known(1.0)
    elif sigma is not None:
        noise = NoiseLevel.known(sigma)
    else:
        noise = NoiseLevel.inferred(bounds) if bounds is not None else NoiseLevel.inferred()
    rule = PriorRule(prior, data.size, data.size / 2, tau, stated, pixel)
    return LinearModel(factorise(data, order), order, noise, rule.of_order(order), data.symbol)


def legendre_columns(data: AxisData, order: int) -> np.ndarray:
    """Legendre polynomials of the scaled regressor by Bonnet's recursion."""
    lower, upper = data.x.min(), data.x.max()
    s = (2 * data.x - lower - upper) / (upper - lower)
    columns = [np.ones_like(s), s]
    for k in range(1, order):
        columns.append(((2 * k + 1) * s * columns[k] - k * columns[k - 1]) / (k + 1))
    return np.column_stack(columns[: order + 1])


def prior_deviations(prior: CoefficientPrior, tau: float) -> np.ndarray:
    """Standard deviations of the amplitudes at one tau."""
    return np.where(prior.scaled, tau * prior.sd, prior.sd)
