"""Results as tables of pandas, a row per order, model, lens or point; NaN where there is none."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, TypeAlias

from bayescal.comparison.criteria.information import ACROSS, CRITERIA

if TYPE_CHECKING:  # pandas is imported where somebody asks for it
    import pandas as pd

# An OrderResult, whose methods call what follows.
OrderResult: TypeAlias = Any


def orders_frame(orders: Iterable[tuple[str, OrderResult]]) -> pd.DataFrame:
    """Make a data frame with a row per axis and order; what is unavailable is NaN."""
    rows = [
        {
            "axis": axis,
            "order": found.order,
            "p": len(found.fit.coefficients),
            "rss_px2": found.rss_px2,
            "sigma_hat": found.fit.sigma_hat,
            "chi2": found.goodness.chi2,
            "dof": found.fit.dof,
            **{c.key: found.criteria.values.get(c.key) for c in CRITERIA},
            "log_evidence": found.log_evidence,
            "probability": found.probability,
            "elpd": None if found.loo is None else found.loo.elpd,
            "sound": found.sound,
        }
        for axis, found in orders
    ]
    return _indexed(rows, "axis", "order").infer_objects()


def models_frame(models: Iterable[Any]) -> pd.DataFrame:
    """Make a data frame with a row per joint model; what can't be had is NaN."""
    rows = [
        {
            "model": str(found.key),
            "family": found.key.family,
            "order": found.key.order,
            "position": found.key.position,
            "p": found.criteria.n_parameters,
            "chi2": None if found.goodness is None else found.goodness.chi2,
            **{c.key: found.criteria.values.get(c.key) for c in ACROSS},
            "log_evidence": found.log_evidence,
            "log_evidence_error": found.log_evidence_error,
            "probability": found.probability,
            "elpd": None if found.loo is None else found.loo.elpd,
            "sound": found.sound,
        }
        for found in models
    ]
    return _indexed(rows, "model").infer_objects()


def lenses_frame(lenses: Iterable[Any]) -> pd.DataFrame:
    """Make a data frame with a row per lens; what can't be had is NaN."""
    rows = [
        {
            "lens": found.name,
            "rms_px": found.rms,
            "p": found.n_parameters,
            "chi2": found.chi2,
            "aic": found.aic,
            "bic": found.bic,
            "log_evidence": found.log_evidence,
            "log_evidence_error": found.log_evidence_error,
            "probability": found.probability,
            "elpd": None if found.loo is None else found.loo.elpd,
            "difference_px": found.difference,
            "sound": found.sound,
        }
        for found in lenses
    ]
    return _indexed(rows, "lens").infer_objects()


def bad_points_frame(axes: Iterable[Any]) -> pd.DataFrame:
    """Make a data frame with a row per axis and point, the most suspicious first."""
    rows = [
        {"axis": axis.data.axis, "point": p.label, **asdict(p)}
        for axis in axes
        for p in axis.points
    ]
    return _indexed(rows, "axis", "point").drop(columns="label")


def treatments_frame(axes: Iterable[Any]) -> pd.DataFrame:
    """Make a data frame with a row per axis, treatment of bad points, and order."""
    rows = [
        {
            "axis": axis.data.axis,
            "treatment": treatment.name,
            "order": judged.key.orders[0],
            "n": treatment.n_points,
            "log_evidence": judged.log_evidence,
            "log_evidence_error": judged.log_evidence_error,
            "probability": judged.probability,
            "sound": judged.sound,
        }
        for axis in axes
        for treatment in axis.treatments
        for judged in treatment.orders
    ]
    return _indexed(rows, "axis", "treatment", "order")


def _indexed(rows: list[dict[str, Any]], *names: str) -> pd.DataFrame:
    import pandas as pd

    return pd.DataFrame(rows).set_index(list(names))
