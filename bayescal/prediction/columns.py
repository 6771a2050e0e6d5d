"""Answers row by row, as files and data frames have them."""

from __future__ import annotations

from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.prediction.calibrated.members import BoolArray
from bayescal.prediction.changed import Change
from bayescal.prediction.locate import Location
from bayescal.prediction.maps import ImageMaps
from bayescal.prediction.measuring import FEW, SOURCES
from bayescal.prediction.pairs import Distances
from bayescal.prediction.predict import Prediction
from bayescal.prediction.target import QUANTITIES, TargetPose
from bayescal.prediction.target import SOURCES as TARGET_SOURCES

NO_SOLUTION = "nothing in the calibrated domain appears there"
NO_MEETING = "no ray there, or it does not meet the surface in front of the camera"
NO_DIRECTION = "no direction of the ideal camera appears there"
NEAR_ZERO = "may be 0"
NO_DISTANCE = "an end has no solution, or several"


def prediction_columns(found: Prediction) -> dict[str, Any]:
    """Name the columns of a prediction."""
    forms = (
        ("{}", found.mean),
        ("sd_{}", found.sd),
        ("between_sd_{}", found.between),
        ("new_sd_{}", found.new_sd),
        ("lower_{}", found.lower),
        ("upper_{}", found.upper),
    )
    return _spread(forms, ("r", "c")) | {"note": remarks(found)}


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


def location_columns(found: Location) -> dict[str, Any]:
    """Name the columns of points or directions."""
    forms = (
        ("{}", found.values),
        ("sd_{}", found.sd),
        ("linear_sd_{}", found.linear_sd),
        ("lower_{}", found.lower),
        ("upper_{}", found.upper),
        *((f"{source}_sd_{{}}", found.parts[source]) for source in SOURCES),
    )
    flat = found.surface is not None
    columns = _spread(forms, ("x", "y", "z") if flat else ("dx", "dy", "dz"))
    if not flat:
        columns["angle_sd"] = found.angle
    return columns | {"note": location_remarks(found)}


def location_remarks(found: Location) -> list[str]:
    """Say of each pixel why it has no answer, or what stands against it."""
    out = []
    for i, ok in enumerate(found.found):
        words = ["outside the image"] * bool(found.outside[i])
        if ok:
            words += ["extrapolated"] * bool(found.extrapolated[i])
            words += ["linear propagation differs"] * bool(found.nonlinear[i])
            words += [few_words(found.share[i])] * bool(found.share[i] < FEW)
        elif found.count[i] > 1:
            words.append(f"{found.count[i]} points of the calibrated domain appear there")
        elif found.count[i] == 0:
            words.append(NO_SOLUTION)
        else:
            words.append(NO_MEETING)
        out.append(", ".join(words))
    return out


def pair_columns(found: Distances) -> dict[str, Any]:
    """Name the columns of distances."""
    columns: dict[str, Any] = {"distance": found.values, "u": found.u, "k": found.k}
    columns |= {"U": found.expanded, "U_error": found.expanded_error, "linear_u": found.linear_u}
    columns |= {f"u_{name}": found.parts[name] for name in SOURCES}
    return columns | {"share": found.share, "note": pair_remarks(found)}


def pair_remarks(found: Distances) -> list[str]:
    """Say of each pair why it has no distance or expanded uncertainty, or may be one point."""
    known = zip(found.found, found.certain, found.apart, found.share, strict=True)
    return [
        NO_DISTANCE if not ok else few_words(share) if not certain else NEAR_ZERO * (not apart)
        for ok, certain, apart, share in known
    ]


def few_words(share: float) -> str:
    """Say how few draws have an answer."""
    return f"{100 * share:.0f}% of draws answer"


def target_columns(found: TargetPose) -> dict[str, Any]:
    """Name the columns of a pose: a row for each number of it, world units and rad."""
    return {
        "quantity": list(QUANTITIES),
        "value": np.concatenate([found.position, found.rotation]),
        "sd": found.sd,
        "linear_sd": np.sqrt(np.diag(found.linear_covariance)),
        **{f"{source}_sd": found.parts[source] for source in TARGET_SOURCES},
    }


def map_columns(found: ImageMaps) -> dict[str, Any]:
    """Name the columns of maps over the image: a row for each place."""
    at = found.places
    columns: dict[str, Any] = {
        "r": at.pixels[:, 0],
        "c": at.pixels[:, 1],
        "sd": found.epistemic,
        "new_sd": found.predictive,
        "averaged_sd": found.averaged,
    }
    for one in found.differences:
        shifts = {f"to {one.other}: {axis}": one.shift[:, i] for i, axis in enumerate("rc")}
        columns |= {**shifts, f"to {one.other}: sd": one.sd}
    columns["note"] = [
        "" if inside else "extrapolated" if ok else "no inverse"
        for ok, inside in zip(at.found, at.inside, strict=True)
    ]
    return columns


def change_columns(found: Change) -> dict[str, Any]:
    """Name the columns of a change: a row for each place of the grid."""
    at = found.places
    return {
        "r": at.pixels[:, 0],
        "c": at.pixels[:, 1],
        "change_r": found.shift[:, 0],
        "change_c": found.shift[:, 1],
        "sd": found.sd,
        "note": [
            "" if inside else "extrapolated" if seen else "not seen by both"
            for inside, seen in zip(at.inside, np.isfinite(found.sd), strict=True)
        ],
    }


def undistorted_columns(found: Array, outside: BoolArray) -> dict[str, Any]:
    """Name the columns of undistorted pixels ``(n, 2)``, of which some were off the image."""
    seen = np.isfinite(found).all(axis=1)
    columns: dict[str, Any] = {f"undistorted_{a}": found[:, i] for i, a in enumerate("rc")}
    columns["note"] = [
        ", ".join(["outside the image"] * bool(out) + [NO_DIRECTION] * (not ok))
        for ok, out in zip(seen, outside, strict=True)
    ]
    return columns


def _spread(forms: tuple[tuple[str, Array], ...], names: tuple[str, ...]) -> dict[str, Any]:
    """Give each array ``(n, len(names))`` a column for each of its own."""
    return {form.format(name): array[:, i] for form, array in forms for i, name in enumerate(names)}
