"""What the JSON documents share: the points' description, and the way they are written."""

from __future__ import annotations

import json
from typing import Any

from bayescal.points.correspondences import Correspondences


def dumps(found: dict[str, Any]) -> str:
    """Format a document as JSON text; refuses NaN."""
    return json.dumps(found, indent=1, allow_nan=False, ensure_ascii=True) + "\n"


def points_facts(points: Correspondences) -> dict[str, Any]:
    """Collect what a result document says of the points and the camera."""
    setup = points.setup
    return {
        "source": points.source,
        "sha256": points.sha256,
        "n_points": len(points),
        "image": {"width_px": setup.width, "height_px": setup.height},
        "camera_position": list(setup.position),
        "c_from_bottom": setup.c_from_bottom,
        "assumed": list(setup.assumed),
    }
