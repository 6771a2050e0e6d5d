"""``bayescal plot``: one figure of a comparison."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.many import many_or_few
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import DONE, add_manner, check_file, code_of
from bayescal.errors import InputError
from bayescal.report.figures.registry import (
    ALIASES,
    CAMERA,
    FIGURES,
    KINDS,
    FigureKind,
    figure_kinds,
)

if TYPE_CHECKING:
    from bayescal.comparison.results import Comparison

DESCRIPTION = (
    "Draw one figure of a comparison, made now from POINTS or reopened from a RUN that compare "
    "--out wrote. What the figure needs is computed. Of a RUN that compare "
    f"--family --out wrote: {', '.join(figure_kinds('families'))}; of one that outliers --out "
    f"wrote: bad-points; of one that calibrate --out wrote: {', '.join(figure_kinds('lenses'))}."
)
SUFFIXES = (".png", ".svg", ".pdf")
# --axis chooses among what a run holds.
SETTLED = ("orders", *shared.CAMERA, *shared.MODEL)


class _ListKinds(argparse.Action):
    """Prints the kinds and ends, as --help does."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,  # noqa: ARG002 (argparse's own signature)
        values: str | Sequence[Any] | None,  # noqa: ARG002
        option_string: str | None = None,  # noqa: ARG002
    ) -> None:
        from bayescal.report.blocks import Facts
        from bayescal.report.terminal import printed

        pairs = tuple((k.name, f"{k.summary}{_taken(k)}") for k in FIGURES)
        sys.stdout.write(printed((Facts(pairs),)))
        parser.exit(DONE)


def _taken(kind: FigureKind) -> str:
    of = "" if kind.of == "comparison" else f"; of {kind.of}"
    if not kind.one_order:
        return of + ("; --axis" if kind.one_axis else "")
    return "; --axis, --order K" if kind.one_axis else "; both axes, or --axis, --order K"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    option(parser, "kind KIND", f"what to draw: {', '.join(KINDS)}", choices=(*KINDS, *ALIASES))
    option(
        parser,
        "--list",
        "list the kinds with what each shows, and exit",
        action=_ListKinds,
        nargs=0,
    )
    option(parser, "--axis", "which pixel axis", choices=("r", "c"))
    option(parser, "--order K", "which order (the recommended one)", int)
    shared.add_orders(parser)
    shared.add_points(parser, or_run=True)
    shared.add_model(parser)
    output = parser.add_argument_group("output")
    option(output, "--out FILE", "the figure: .png, .svg or .pdf", required=True)
    add_manner(output, "don't say what is to be seen")


def run(options: argparse.Namespace) -> int:
    """Compare or reopen, draw, write; return the exit code."""
    from bayescal.files import write_whole

    path = Path(options.out)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"{path}: a figure is written as {', '.join(SUFFIXES)}; name it so")
    check_file(options, path)
    options.kind = ALIASES.get(options.kind, options.kind)
    kind, result = _held(KINDS[options.kind], options)
    if result is None:
        result = _compared(kind, options)
    figure = kind.draw(result, options.axis, options.order)
    words = kind.alt_text(result, options.axis, options.order)
    from bayescal.report.figures.style import figure_bytes

    write_whole(path, figure_bytes(figure, suffix[1:]), force=options.force)
    if not options.quiet:
        print(f"{path}: {words}")
    return code_of(sound=getattr(result, "sound", True))


def _check(kind: FigureKind, options: argparse.Namespace) -> None:
    """Refuse, before anything is sampled, what can't be drawn.

    Raises
    ------
    InputError
    """
    if kind.of not in ("comparison", CAMERA):
        from bayescal.report.runs import kind_named

        made_by = kind_named(kind.of).made_by
        raise InputError(f"{kind.name} is of {kind.of}: name a run that {made_by} --out wrote")
    if options.order is not None and not kind.one_order:
        raise InputError(f"{kind.name} shows every order; leave out --order")
    if options.axis is None and (kind.one_axis or options.order is not None):
        raise InputError(f"{kind.name} needs an axis here; add --axis r or --axis c")
    if options.order is not None and options.order not in shared.orders_of(options):
        raise InputError(f"order {options.order} is not among --orders; name it there too")


def _compared(kind: FigureKind, options: argparse.Namespace) -> Comparison:
    _check(kind, options)
    axes = shared.axes_of(options)
    models = len(shared.orders_of(options)) * axes
    with many_or_few(options, models) as points, shared.Progress(options, models) as progress:
        from bayescal.api.axes import compare
        from bayescal.points.correspondences import Correspondences

        # Of many points a sample is held, which alone can't be left out or resampled.
        many = not isinstance(points, Correspondences)
        return compare(
            points,
            defend=kind.of_defence and many,
            hint=False,
            progress=progress,
            **shared.settings(options),
        )


def _held(kind: FigureKind, options: argparse.Namespace) -> tuple[FigureKind, Any]:
    """Take what is drawn out of a run or a camera's file, with its kind; None of points."""
    kept = options.points is not None and options.points.endswith(".npz") and kind.of == CAMERA
    if not (kept or shared.is_run(options, SETTLED)):
        return kind, None
    if kind.of != CAMERA:
        from bayescal.report.runs import kind_at

        kind = figure_kinds(kind_at(Path(options.points)).name).get(options.kind, kind)
        return kind, _reopened(kind, options)
    from bayescal.report.camera import camera_at
    from bayescal.report.figures.registry import maps_of

    return kind, maps_of(camera_at(options.points))


def _reopened(kind: FigureKind, options: argparse.Namespace) -> Any:
    from bayescal.report.runs import kind_named

    held = kind_named(kind.of)
    # What it does not show is not read; what the run does not hold is computed for it alone.
    defend = False if held.defended and not kind.of_defence else None
    return held.open(Path(options.points), defend=defend)
