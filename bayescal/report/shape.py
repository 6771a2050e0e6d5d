"""What a result document must hold for its run to be reopened."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Maybe:
    """What may be null, and what it must hold where it is not."""

    shape: Any


NUMBER = (int, float, type(None))
COEFFICIENT = {"name": str, "mean": NUMBER, "sd": NUMBER}
ORDER = {
    "order": int,
    "log_evidence": NUMBER,
    "log_likelihood_max": NUMBER,
    "probability": NUMBER,
    "coefficients": [COEFFICIENT],
}
AXIS = {"orders": [ORDER], "verdict": {"order": NUMBER}, "defence": (dict, type(None))}
DOCUMENT = {
    "family": str,
    "provenance": {"command": str},
    "settings": {
        "sigma": (*NUMBER, str),
        "prior": (str, type(None)),
        "tau": NUMBER,
        "seed": int,
        "ess": int,
        "defend": bool,
    },
    "data": {"source": str, "sha256": str},
    "axes": dict,
}


def misshapen(
    found: Mapping[str, Any],
    shape: Mapping[str, Any] = DOCUMENT,
    axis_shape: Mapping[str, Any] | None = AXIS,
) -> str | None:
    """Name the first thing that a result document lacks or has of another kind; None: nothing.

    Parameters
    ----------
    found : mapping
        The document.
    shape, axis_shape : mapping, optional
        What all of it must hold, and each of its axes where it has axes; of a comparison by
        default.
    """
    wrong = _misfit(found, shape, "")
    if wrong is not None or axis_shape is None:
        return wrong
    axes = found["axes"]
    if not axes or not set(axes) <= {"r", "c"}:
        return "axes"
    misfits = (_misfit(axis, axis_shape, f"axes.{name}") for name, axis in axes.items())
    return next((m for m in misfits if m is not None), None)


def _misfit(found: Any, wanted: Any, place: str) -> str | None:
    """Place of the first misfit within a value; None where it fits."""
    if isinstance(wanted, Maybe):
        return None if found is None else _misfit(found, wanted.shape, place)
    if isinstance(wanted, Mapping):
        if not isinstance(found, Mapping):
            return place
        parts = ((found.get(k, ...), w, f"{place}.{k}".lstrip(".")) for k, w in wanted.items())
    elif isinstance(wanted, list):
        if not isinstance(found, list) or not found:
            return place
        parts = ((item, wanted[0], f"{place}.{i}") for i, item in enumerate(found))
    else:
        return None if isinstance(found, wanted) else place
    return next((m for part in parts if (m := _misfit(*part)) is not None), None)
