"""Points of a command that reads many in chunks."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.streams import say

if TYPE_CHECKING:
    from bayescal.comparison.results import Comparison
    from bayescal.points.chunks.many import ManyPoints
    from bayescal.points.correspondences import Correspondences

# Processor time of a model for each point, s: some 40,000 draws that look at it, under robust
# noise; with a pose or a position of its own.
ROBUST, POSE = 1.2e-4, 2.2e-3


@contextlib.contextmanager
def many_or_few(
    options: argparse.Namespace, models: int, each: float | None = None
) -> Iterator[Correspondences | ManyPoints]:
    """Give points that are read in chunks where they are many, else as `points`.

    Each time they are read there is a line of progress, which goes from nothing to the end. Where
    each of so many models looks at every point, `each` so many seconds at one (by default under
    robust noise alone), it is said how long that takes.
    """
    source, second = shared.files(options)
    many = None
    if source is not None and second is None and options.view is None:
        from bayescal.points.chunks.many import many_points

        many = many_points(source, options.columns)
    if many is None:
        yield shared.points(options)
        return
    about = many.found.about
    if each is None and options.noise not in (None, "gaussian"):
        each = ROBUST
    if each is not None:
        say_many(options, about, models, each)
    with contextlib.ExitStack() as line:

        def begun() -> Callable[[int], None]:
            line.close()
            return line.enter_context(shared.Progress(options, about, "reading points,")).more

        yield shared.with_camera(dataclasses.replace(many, begun=begun), options)


def compared(options: argparse.Namespace, *, heavy: int, **how: Any) -> Comparison:
    """Compare the orders that the options name, with progress.

    Parameters
    ----------
    heavy : int
        Steps beside the models.
    **how
        As `bayescal.compare` takes it.
    """
    models = len(shared.orders_of(options)) * shared.axes_of(options)
    with (
        many_or_few(options, models) as points,
        shared.Progress(options, models, heavy=heavy) as progress,
    ):
        from bayescal.api.axes import compare

        return compare(points, progress=progress, **how, **shared.settings(options))


def say_many(options: argparse.Namespace, n: int, models: int, each: float) -> None:
    """Say how long many points take where each draw looks at every one of them.

    Parameters
    ----------
    models : int
        How many are fitted.
    each : float
        Seconds of one for each point.
    """
    from bayescal.points.chunks.chunk import HELD
    from bayescal.rounding import grouped

    if n <= HELD or options.quiet:
        return
    one = n * each
    whole = f"{_time(one)} a model, {_time(one * models)} in all"
    beside = "; a defence takes several times that" if vars(options).get("defend") else ""
    say(f"{grouped(n)} points, at all of which every draw looks: about {whole}{beside}")


def _time(seconds: float) -> str:
    """Write a time that is known to a factor of two."""
    if seconds < 90:
        return f"{float(f'{seconds:.1g}'):.3g} s"
    if seconds < 5400:
        return f"{float(f'{seconds / 60:.2g}'):.3g} min"
    return f"{float(f'{seconds / 3600:.2g}'):.3g} h"
