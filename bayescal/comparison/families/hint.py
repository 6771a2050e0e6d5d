"""Whether a comparison of orders should have been one of families: the line that says so."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp
from threadpoolctl import threadpool_limits

from bayescal.comparison.axis import Axis
from bayescal.comparison.families.models import (
    free_model,
    gaussian_pinhole,
    joint_criteria,
    joint_data,
)
from bayescal.comparison.key import FREE
from bayescal.comparison.results import Comparison
from bayescal.comparison.settings import Settings
from bayescal.density.pinhole_proposal import ladder
from bayescal.density.position_search import position_mode
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES

# Points that no such model can be fitted to: a comparison of orders goes on without the line.
NO_MODEL = (InputError, np.linalg.LinAlgError, ValueError)
# 2 ln B worth a line in a comparison of orders: very strong (Kass & Raftery 1995).
DECISIVE = 10.0


def family_hint(points: Correspondences, result: Comparison, settings: Settings) -> str | None:
    """Say in one line whether another family, or a free position, is decisively better.

    The pinhole of orders 0 and 1 and the recommended pair of orders at a free position, by
    Laplace approximations of the evidence, against the pair at the stated position. None
    where 2 ln B is below 10, where there is no evidence, or where no such model can be had.
    """
    axes = result.axes
    if set(axes) != set(AXES) or settings.noise != "gaussian":
        return None
    chosen = [axes[name].chosen for name in AXES]
    if any(c.log_evidence is None or c.criteria.bic is None for c in chosen):
        return None
    bic = sum(c.criteria.bic or 0.0 for c in chosen)
    stated = sum(c.log_evidence or 0.0 for c in chosen)
    with threadpool_limits(1), np.errstate(all="ignore"):
        found = _rivals(points, result, settings)
    if not found:
        return None
    best = max(found, key=lambda rival: rival.log_evidence)
    gain = 2 * (best.log_evidence - stated)
    if gain < DECISIVE:
        return None
    x, y, z = best.position
    changed = ""
    if best.bic is not None:
        changed = f", BIC {'lower' if best.bic < bic else 'higher'} by {abs(bic - best.bic):.0f}"
    return (
        f"{best.name} with a free camera position (near {x:.4g}, {y:.4g}, {z:.4g}) describes these "
        f"points decisively better: 2 ln B about {gain:.0f} (Laplace){changed}; "
        "see compare --family separable,pinhole --position stated,free"
    )


@dataclass(frozen=True)
class _Rival:
    """A model that might beat the recommended orders at the stated position."""

    log_evidence: float
    bic: float | None  # None of an exact fit
    name: str
    position: tuple[float, ...]


def _rivals(points: Correspondences, result: Comparison, settings: Settings) -> list[_Rival]:
    """Fit the models of the hint, as far as the points allow."""
    k, m = (result.axes[name].chosen.order for name in AXES)
    r, c = (
        Axis(a.data, a.noise, a.noise_source, a.prior, result.family, a.orders[-1].order)
        for a in (result.axes[name] for name in AXES)
    )
    data, out = joint_data((r, c)), []
    with contextlib.suppress(*NO_MODEL):
        model, rss = free_model(points, (r, c), (k, m))
        bic = joint_criteria(data, rss, k + m + 5 + sum(data.inferred)).bic
        mass = position_mode(model).log_mass
        out.append(_Rival(mass, bic, f"separable ({k}, {m})", tuple(model.start.tolist())))
    with contextlib.suppress(*NO_MODEL):
        for order in (0, 1):
            pinhole = gaussian_pinhole(points, order, FREE, "even", data, settings)
            _, log_mass = ladder(pinhole)
            position = pinhole.geometry.position(pinhole.geometry.full(pinhole.fit.free[None]))[0]
            count = pinhole.geometry.dimension + sum(data.inferred)
            bic = joint_criteria(data, pinhole.fit.rss, count).bic
            mass = float(logsumexp(log_mass))
            out.append(_Rival(mass, bic, f"pinhole of order {order}", tuple(position.tolist())))
    return out
