"""Predictions row by row, as files and data frames have them."""

from __future__ import annotations

from typing import Any

from bayescal.prediction.predict import Prediction


def prediction_columns(found: Prediction) -> dict[str, Any]:
    """Name the columns of a prediction, as files and data frames have them."""
    out: dict[str, Any] = {}
    for name, array in (
        ("{}", found.mean),
        ("sd_{}", found.sd),
        ("between_sd_{}", found.between),
        ("new_sd_{}", found.new_sd),
        ("lower_{}", found.lower),
        ("upper_{}", found.upper),
    ):
        out |= {name.format(axis): array[:, i] for i, axis in enumerate("rc")}
    out["note"] = remarks(found)
    return out


def remarks(found: Prediction) -> list[str]:
    """Say of each row what stands against it; empty where nothing does."""
    return [
        "behind the camera, or beyond the lens's reach"
        if not seen
        else ", ".join(
            ["outside the image"] * bool(outside) + ["extrapolated"] * bool(extrapolated)
        )
        for seen, outside, extrapolated in zip(
            found.seen, found.outside, found.extrapolated, strict=True
        )
    ]
