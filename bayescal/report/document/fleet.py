"""The document of a fleet of cameras."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from bayescal.fleets.fleet import Fleet
from bayescal.fleets.odd import LEVEL, score_limit
from bayescal.report.document.shared import provenance

SCHEMA = "bayescal.fleet/1"


def fleet_document(fleet: Fleet, command: str) -> dict[str, Any]:
    """Build the result document: JSON values only, null where there is nothing.

    Parameters
    ----------
    command : str
        How it was asked for, for the provenance.
    """
    rows = fleet.columns
    limit = score_limit(fleet.spreads)
    return {
        "schema": SCHEMA,
        "provenance": {**provenance(command), "seed": fleet.settings["seed"]},
        "settings": fleet.settings,
        "data": {
            "n_cameras": len(fleet),
            "n_failed": len(fleet.failed),
            "n_points": sum(record.n_points for record in fleet.records.values()),
        },
        "report": fleet.heading.facts,
        "common": fleet.common,
        "spreads": [
            {"of": s.of, "name": s.name, "n": len(s.values), "median": s.median, "sd": s.scale}
            for s in fleet.spreads
        ],
        "odd": {
            "level": LEVEL,
            "score_limit": limit if limit < float("inf") else None,
            "found": [asdict(odd) for odd in fleet.odd],
        },
        "cameras": [
            dict(zip(rows, values, strict=True)) for values in zip(*rows.values(), strict=True)
        ],
    }
