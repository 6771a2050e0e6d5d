"""What a comparison assumed because nobody said otherwise, in words."""

from __future__ import annotations

from collections.abc import Iterable

from bayescal.comparison.results import AxisComparison
from bayescal.points.correspondences import Correspondences
from bayescal.points.notes import point_notes


def notes(points: Correspondences, axes: Iterable[AxisComparison]) -> tuple[str, ...]:
    """Say what is odd about the points, and what was assumed because nobody said otherwise."""
    return (
        *point_notes(points),
        *(
            f"{axis.data.axis}: the image size is not known; the span of the pixels, "
            f"{axis.data.size:g} px, stands for it in the prior"
            for axis in axes
            if not axis.data.size_known
        ),
    )
