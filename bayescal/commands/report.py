"""``bayescal report``: one page to attach to a calibration."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from bayescal.commands import options as shared
from bayescal.commands.output import add_progress, check_file, exit_code
from bayescal.errors import InputError

if TYPE_CHECKING:
    from bayescal.comparison.results import Comparison

HELP = "one page to attach to a calibration (HTML, PDF)"
DESCRIPTION = (
    "Write a comparison with its defence as one self-contained HTML page, made now from POINTS or "
    "reopened from a RUN that compare --out wrote."
)
SETTLED = (*shared.COMPARED, *shared.CAMERA, *shared.MODEL)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    shared.add_orders(parser)
    shared.add_axis(parser)
    shared.add_points(parser)
    shared.add_model(parser)
    output = parser.add_argument_group("output")
    output.add_argument("--out", required=True, metavar="FILE.html", help="the page")
    output.add_argument(
        "--pdf", metavar="FILE.pdf", help="print it too, with the Chromium found on the PATH"
    )
    output.add_argument("--force", action="store_true", help="replace existing files")
    output.add_argument("--quiet", action="store_true", help="don't say the verdict")
    add_progress(output)


def run(options: argparse.Namespace) -> int:
    """Compare or reopen, write the page; return the exit code."""
    from bayescal.files import write_whole
    from bayescal.report.page.pdf import find_browser, print_pdf

    out = Path(options.out)
    check_file(options, out)
    browser = None
    if options.pdf is not None:
        if Path(options.pdf).resolve() == out.resolve():
            raise InputError(f"{options.pdf}: is named by --out too; give the PDF another name")
        check_file(options, Path(options.pdf))
        browser = find_browser()
    result = _reopened(options) if shared.is_run(options, SETTLED) else _compared(options)
    from bayescal.report.page.page import html, page_of

    page = page_of(result, options.command_line)
    made = html(page)
    if browser is not None:
        created = page.made_by.rpartition(" ")[2]
        write_whole(Path(options.pdf), print_pdf(made, browser, created), force=options.force)
    write_whole(out, made.encode(), force=options.force)
    if not options.quiet:
        size = len(made.encode()) / 1e6
        print(f"{out}: {size:.1f} MB" + (f"; {options.pdf}" if browser is not None else ""))
        for name, order in result.orders.items():
            print(f"{name}: " + (f"order {order}" if order is not None else "no order"))
    return exit_code(result)


def _compared(options: argparse.Namespace) -> Comparison:
    from bayescal.api.axes import compare

    points = shared.points(options)
    models = len(shared.orders_of(options)) * shared.axes_of(options)
    with shared.Progress(options, models) as progress:
        return compare(
            points,
            defend=True,
            progress=progress,
            **shared.settings(options),
        )


def _reopened(options: argparse.Namespace) -> Comparison:
    from bayescal.report.reopen import open_run

    return open_run(options.points, defend=True)
