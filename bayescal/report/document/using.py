"""What a calibrated camera answers, as documents: rows, and the pose of a target."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from typing import Any

import numpy as np

from bayescal.arrays import finite
from bayescal.points.tables.partial import PartialTable
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.changed import LEVEL, Change
from bayescal.prediction.columns import change_columns
from bayescal.prediction.target import QUANTITIES, TargetPose
from bayescal.report.document.shared import dumps, provenance

PREDICTION, LOCATION = "bayescal.prediction/1", "bayescal.location/1"
DISTANCES, TARGET = "bayescal.distances/1", "bayescal.target/1"
MAPS, CHANGE = "bayescal.maps/1", "bayescal.change/1"
PACKAGES = ("numpy", "scipy")


def asked_and_found(
    table: PartialTable, asked: tuple[str, ...], found: Mapping[str, Any]
) -> dict[str, Any]:
    """Put what was asked for before what was found."""
    given = {name: table.values[name] for name in asked}
    return {"label": list(table.labels), **given, **found}


def rows_text(columns: Mapping[str, Any]) -> str:
    """Rows as CSV: ten significant digits, and nothing where there is no number."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow([value if isinstance(value, str) else _digits(value) for value in row])
    return stream.getvalue()


def rows_document(
    schema: str, camera: CalibratedCamera, columns: Mapping[str, Any], command: str, **facts: Any
) -> str:
    """Rows as a JSON document, with the models they come from."""
    return dumps({**camera_facts(schema, camera, command), **facts, "rows": _rows(columns)})


def camera_facts(schema: str, camera: CalibratedCamera, command: str) -> dict[str, Any]:
    """Say which models answer, and how much of the probability they have."""
    members, weights = camera.used
    return {
        "schema": schema,
        "provenance": provenance(command, packages=PACKAGES),
        "calibration": camera.source,
        "models": [
            {"name": m.name, "probability": p} for m, p in zip(members, weights, strict=True)
        ],
        "averaged": camera.averaged,
        "covered": camera.covered,
    }


def target_document(camera: CalibratedCamera, found: TargetPose, command: str) -> str:
    """Write the pose of a target as a JSON document."""
    return dumps({**camera_facts(TARGET, camera, command), **_pose(found)})


def _pose(found: TargetPose) -> dict[str, Any]:
    second = None if found.second is None else {**_pose(found.second), "odds": found.odds}
    return {
        "frame": found.frame,
        "rotation_vector_rad": found.rotation.tolist(),
        "position": found.position.tolist(),
        "quantities": list(QUANTITIES),
        "covariance": found.covariance.tolist(),
        "linear_covariance": found.linear_covariance.tolist(),
        "linear_sd_by_source": {name: part.tolist() for name, part in found.parts.items()},
        "n_points": len(found.residuals),
        "residuals_px": found.residuals.tolist(),
        "rms_px": found.rms,
        "chi2": found.chi2,
        "dof": found.dof,
        "p_value": found.p_value,
        "mirrored_chi2": found.mirrored,
        "extrapolated": int(found.extrapolated.sum()),
        "second": second,
    }


def change_document(
    first: CalibratedCamera,
    second: CalibratedCamera,
    found: Change,
    names: tuple[str, str],
    command: str,
) -> str:
    """Write how two calibrations, of runs or files so named, differ as a JSON document."""
    own, other = (camera_facts(CHANGE, camera, command) for camera in (first, second))
    then = {key: other[key] for key in ("calibration", "models", "averaged", "covered")}
    facts = {
        "compared": list(names),
        "p_value": found.p_value,
        "tested_models": list(found.tested),
        "by_data_alone": found.by_data,
        "changed": found.changed,
        "rms_px": found.rms,
        "bound_px": found.bound,
        "bound_probability": 1 - LEVEL,
        "posed": found.posed,
        "text": found.verdict,
    }
    return dumps({**own, "second": then, **facts, "rows": _rows(change_columns(found))})


def _rows(columns: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [
        {name: _json(value) for name, value in zip(columns, row, strict=True)}
        for row in zip(*columns.values(), strict=True)
    ]


def _json(value: Any) -> Any:
    return value if isinstance(value, str) else finite(value)


def _digits(value: float) -> str:
    return f"{value:.10g}" if np.isfinite(value) else ""
