"""Bad points, and whether the order depends on them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from bayescal.api.given import Given, GivenSetup, points_of, resumed
from bayescal.comparison.outliers.analysis import find_outliers
from bayescal.comparison.outliers.rejection import RejectionRule
from bayescal.comparison.outliers.request import OutlierRequest
from bayescal.comparison.outliers.results import OutlierStudy
from bayescal.comparison.settings import DEFAULT_ESS, DEFAULT_ORDERS, Settings, checked_orders
from bayescal.errors import InputError
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.points.reader import axis_names

SIGNIFICANCE = 0.05


def outliers(
    points: Given,
    orders: Iterable[int] = DEFAULT_ORDERS,
    *,
    axis: str = "both",
    sigma: float | str | None = None,
    prior: str | None = None,
    tau: float | None = None,
    nu: float | None = None,
    bad_offset: bool = False,
    significance: float = SIGNIFICANCE,
    seed: int = 0,
    ess: int = DEFAULT_ESS,
    setup: GivenSetup = None,
    resume: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
) -> OutlierStudy:
    """Find bad points, and whether the choice of the order depends on them.

    Parameters
    ----------
    points : Correspondences, str, Path, DataFrame or array_like
        From `load`, `thesis` or ``Correspondences.from_arrays``, or anything `load` takes.
    orders : iterable of int, optional
        Polynomial degrees, 1 to 5 by default.
    axis : str, optional
        ``"r"``, ``"c"`` or ``"both"``.
    sigma, prior, tau, seed
        As in `compare`.
    nu : float, optional
        Fixes the degrees of freedom of Student-t noise; by default they are inferred.
    bad_offset : bool, optional
        Infer an offset of the mixture's bad points; by default it is zero.
    significance : float, optional
        Of the chi-squared elimination, family-wise.
    ess : int, optional
        Effective samples wanted of every parameter.
    setup : Setup or str or Path, optional
        What is known of the camera, where the points don't know it.
    resume : str or Path, optional
        Folder that keeps what was sampled without a closed form as soon as it is: called again
        with the same arguments after an interruption, it goes on from there.
    progress : callable, optional
        Called with the axis before each noise model is sampled.

    Returns
    -------
    OutlierStudy
        Per axis every point's residual, leverage, Cook's distance, chi-squared rejection and
        probability of being bad, and the orders under each treatment of bad points.

    Raises
    ------
    InputError
        Where the points can't determine an order, or a setting is not usable.

    Notes
    -----
    The mixture of good and bad points is that of Hogg, Bovy & Lang 2010, arXiv:1008.4686.
    """
    wanted = checked_orders(orders)
    settings = Settings(sigma, prior, tau, seed, ess)
    noises = StudentT(nu), OutlierMixture(infers_offset=bad_offset)
    rule = RejectionRule(significance)
    if prior == "flat":
        raise InputError("outliers compares evidences, which a flat prior does not have")
    points = points_of(points, setup)
    request = OutlierRequest(axis_names(axis), wanted, noises, rule)
    store = resumed(resume, points, settings, (request.axes, wanted, noises))
    return find_outliers(points, request, settings, progress or (lambda _: None), store)
