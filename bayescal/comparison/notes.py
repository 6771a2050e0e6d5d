"""What a comparison assumed because nobody said otherwise, in words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from bayescal.comparison.results import AxisComparison
from bayescal.points.chunks.chunk import HELD
from bayescal.points.correspondences import Correspondences
from bayescal.points.notes import point_notes


def notes(points: Correspondences, axes: Iterable[AxisComparison]) -> tuple[str, ...]:
    """Say what is odd about the points, and what was assumed because nobody said otherwise."""
    axes = tuple(axes)
    return (
        *sampled_note(points, defended=any(axis.defence is not None for axis in axes)),
        *point_notes(points),
        *(
            f"{axis.data.axis}: the image size is not known; the span of the pixels, "
            f"{axis.data.size:g} px, stands for it in the prior"
            for axis in axes
            if not axis.data.size_known
        ),
    )


def sampled_note(points: Correspondences, *, defended: bool = False) -> Iterator[str]:
    """Say which statistics look at a sample only."""
    if points.drawn_from is not None:
        answers = (
            "; leave-one-out, removals and resamples are of all points too, read once more, but "
            "without groups, draws (PSIS) and other noise"
        )
        yield (
            f"more than {HELD} points are reduced as they are read: least squares, chi-squared, "
            "criteria, evidence and posterior are of all of them, exactly; tests of residuals, "
            "replicates, geometry, figures and the look at other models take "
            f"{len(points)}, drawn at random by the seed{answers if defended else ''}"
        )
