"""What the commands that use a calibrated camera share: its options, bad rows, output."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import DONE
from bayescal.commands.shared.streams import say
from bayescal.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from bayescal.points.tables.partial import PartialTable
    from bayescal.prediction.calibrated.camera import CalibratedCamera


def add_camera(parser: argparse.ArgumentParser) -> None:
    """Add the camera, and which of its models."""
    option(parser, "camera RUN", "a run that --out wrote, or a camera file (camera.npz)")
    models = add_average(parser)
    option(models, "--model NAME", "answer by this plausible model alone")


def add_average(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add whether models are averaged."""
    models = parser.add_argument_group("models")
    option(
        models,
        "--average",
        "average over all plausible models (where the verdict is undecided)",
        action=argparse.BooleanOptionalAction,
    )
    return models


def add_rows(parser: argparse.ArgumentParser) -> None:
    """Add how the rows of a table are read, and where answers go."""
    option(parser, "--columns x=E,y=N,...", "the table's columns by name or number (from 1)")
    option(
        parser,
        "--strict",
        "refuse a table with a bad row (bad rows are named, the others answered)",
    )
    add_output(parser)


def add_output(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add where answers go."""
    output = parser.add_argument_group("output")
    option(output, "--out FILE|-", "write all rows as CSV; - prints them")
    option(output, "--json FILE|-", "write all rows as JSON; - prints them")
    option(output, "--force", "replace existing output")
    option(output, "--quiet", "print no table")
    return output


def camera_of(options: argparse.Namespace) -> CalibratedCamera:
    """Take the camera that the options name."""
    from bayescal.api.camera import camera

    if options.model is not None and options.average:
        raise InputError("--model takes one model alone: leave out --average")
    return camera(options.camera, average=options.average, model=options.model)


def check_rows(options: argparse.Namespace, *read: str | None) -> None:
    """Refuse output that can't be written before anything is computed."""
    from bayescal.files import check_free

    if options.out == options.json == "-":
        raise InputError("--out - and --json - would print into each other; name a file for one")
    for given in (options.out, options.json):
        if given in (None, "-"):
            continue
        path = Path(given)
        check_free(path, force=options.force)
        for source in read:
            if source in (None, "-"):
                continue
            if path.resolve() == Path(source).resolve():
                raise InputError(f"{path}: would replace what is read; choose another name")
            if Path(source).resolve() in path.resolve().parents:
                raise InputError(f"{path}: lies in the run that is read; choose another place")


def read_rows(
    options: argparse.Namespace,
    source: str,
    required: tuple[str, ...],
) -> PartialTable:
    """Read the table of a command; name its bad rows.

    Raises
    ------
    InputError
        Where it can't be read, or has a bad row and --strict is given.
    """
    from bayescal.points.exports.stored_tables import stored_table
    from bayescal.points.tables.columns import parse_stated
    from bayescal.points.tables.partial import read_partial
    from bayescal.report.views.prediction import bad_rows

    stated = None if options.columns is None else parse_stated(options.columns)
    table = read_partial(source, required, stated, stored_table)
    if table.problems and options.strict:
        raise InputError(table.problems[0])
    for line in bad_rows(table.problems):
        say(f"left out: {line}")
    return table


def publish_answers(
    options: argparse.Namespace,
    schema: str,
    camera: CalibratedCamera,
    columns: dict[str, Any],
    view: Callable[[], Any],
    **facts: Any,
) -> int:
    """Write or show what a camera answers, row by row; give the exit code."""
    from bayescal.report.document.using import rows_document

    command = options.command_line
    publish_rows(
        options, columns, lambda: rows_document(schema, camera, columns, command, **facts), view
    )
    return DONE


def publish_rows(
    options: argparse.Namespace,
    columns: dict[str, Any],
    document: Callable[[], str],
    view: Callable[[], Any],
) -> None:
    """Write rows where they are wanted, or show them."""
    from bayescal.files import write_whole
    from bayescal.report.document.using import rows_text

    texts: tuple[tuple[str | None, Callable[[], str]], ...] = (
        (options.out, lambda: rows_text(columns)),
        (options.json, document),
    )
    for given, make in texts:
        if given is None:
            continue
        text = make()
        if given == "-":
            sys.stdout.write(text)
        else:
            write_whole(Path(given), text.encode(), force=options.force)
    if not options.quiet and "-" not in (options.out, options.json):
        from bayescal.report.terminal import printed

        sys.stdout.write(printed(view()))
