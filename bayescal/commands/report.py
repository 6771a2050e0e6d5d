"""``bayescal report``: one page to attach to a calibration."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.families import add_families, families_of
from bayescal.commands.shared.many import compared
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import add_manner, check_file, code_of
from bayescal.commands.shared.streams import print_utf8
from bayescal.errors import InputError, OutputError

if TYPE_CHECKING:
    from bayescal.comparison.families.results import FamilyComparison
    from bayescal.comparison.outliers.results import OutlierStudy
    from bayescal.comparison.results import Comparison
    from bayescal.points.heading import Heading
    from bayescal.report.page.page import Page

DESCRIPTION = (
    "Write a comparison with its defence as one self-contained HTML page, made now from POINTS or "
    "reopened from a RUN that compare, fit, outliers or calibrate --out wrote."
)
SETTLED = (*shared.COMPARED, *shared.CAMERA, *shared.MODEL)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    shared.add_orders(parser)
    shared.add_axis(parser)
    shared.add_points(parser, or_run=True)
    shared.add_model(parser)
    option(
        parser,
        "--outliers",
        "add a section on bad points (about a minute more)",
    )
    add_families(parser, several=True)
    output = parser.add_argument_group("output")
    option(output, "--out FILE.html", "the page; - prints it", required=True)
    option(output, "--pdf FILE.pdf", "a PDF of it too, printed by the Chromium found on the PATH")
    add_manner(output, "don't say the verdict")
    heading = parser.add_argument_group("title block (by default as the setup's [report] says)")
    option(heading, "--title TEXT", "title of the page", default="")
    for name, what in (
        ("camera", "which camera was calibrated"),
        ("serial", "its serial number"),
        ("operator", "who calibrated it"),
    ):
        option(heading, f"--{name} TEXT", what, default="")


def run(options: argparse.Namespace) -> int:
    """Compare or reopen, write the page; return the exit code."""
    from bayescal.files import write_whole
    from bayescal.points.heading import Heading
    from bayescal.report.page.pdf import check_browser, find_browser, print_pdf

    out = Path(options.out)
    printed = options.out == "-"
    if not printed:
        check_file(options, out)
    browser = None
    if options.pdf is not None:
        if Path(options.pdf).resolve() == out.resolve():
            raise InputError(f"{options.pdf}: is named by --out too; give the PDF another name")
        check_file(options, Path(options.pdf))
        browser = find_browser()
        check_browser(browser)
    if options.outliers and options.prior == "flat":
        raise InputError("--outliers compares evidences, which a flat prior does not have")
    asked = families_of(options, "report")
    heading = Heading(options.title, options.camera, options.serial, options.operator)
    page, lines, sound = _page(options, asked, heading)
    from bayescal.report.page.page import html

    made = html(page)
    if printed:
        print_utf8(made)
    else:
        write_whole(out, made.encode(), force=options.force)
    if browser is not None:
        try:
            pdf = print_pdf(made, browser, page.created)
            write_whole(Path(options.pdf), pdf, force=options.force)
        except OutputError as error:
            done = "the page is printed" if printed else f"{out} is written"
            raise OutputError(f"{error}; {done}") from None
    if not options.quiet and not printed:
        size = len(made.encode()) / 1e6
        print(f"{out}: {size:.1f} MB" + (f"; {options.pdf}" if browser is not None else ""))
        print("\n".join(lines))
    return code_of(sound=sound)


def _page(
    options: argparse.Namespace, asked: dict[str, Any] | None, heading: Heading
) -> tuple[Page, list[str], bool]:
    """Make the page, what to say of it in a few lines, and whether it is sound."""
    from bayescal.report.page.page import chapters, page_of
    from bayescal.report.runs import kind_of

    result = _reopened(options, asked) if shared.is_run(options, SETTLED) else None
    if result is None:
        if asked is not None:
            _check_families(options, asked)
        # Each axis's orders and its defence, and a look at other families.
        result = compared(options, heavy=shared.axes_of(options) + 1, defend=True)
    beside: list[Any] = []
    if asked is not None:
        beside.append(_families(options, result, asked))
    if options.outliers:
        beside.append(_bad_points(options, result))
    count = len(chapters(result, *beside))
    with shared.Progress(options, count, "drawing") as progress:
        page = page_of(
            result, options.command_line, *beside, heading=heading, progress=progress.named
        )
    shown = [result, *beside]
    lines = [line for found in shown for line in kind_of(found).views.headlines(found)]
    return page, lines, all(found.sound for found in shown)


def _reopened(options: argparse.Namespace, asked: dict[str, Any] | None) -> Any:
    """Take up a run; refuse to look beside one that holds no comparison of orders."""
    from bayescal.report.runs import kind_at

    place = Path(options.points)
    kind = kind_at(place)
    if kind.name == "comparison":
        return kind.open(place, defend=True)
    if options.outliers or asked is not None:
        what, of = ("--outliers", "outliers") if options.outliers else ("--family", "families")
        about = "which the page is about anyway" if kind.name == of else "which holds nothing else"
        raise InputError(f"{place}: is a run of {kind.name}, {about}; leave out {what}")
    return kind.open(place)


def _check_families(options: argparse.Namespace, asked: dict[str, Any]) -> None:
    """Refuse, before anything is sampled, families that can't be compared so."""
    from bayescal.api.families import family_request
    from bayescal.comparison.families.analysis import check_request
    from bayescal.comparison.settings import Settings

    given = {k: v for k, v in shared.settings(options).items() if k not in shared.COMPARED}
    check_request(family_request(orders=shared.orders_of(options), **asked), Settings(**given))


def _families(
    options: argparse.Namespace, result: Comparison, asked: dict[str, Any]
) -> FamilyComparison:
    """Compare families of models of the same points under the comparison's own settings."""
    from dataclasses import asdict

    from bayescal.api.families import compare_families, family_request

    if result.points is None or len(result.axes) != 2:
        raise InputError(f"{options.points}: holds one axis; families are models of r and c")
    orders = sorted({r.order for axis in result.axes.values() for r in axis.orders})
    given = {k: v for k, v in asdict(result.settings).items() if k != "defend"}
    steps = family_request(orders=orders, **asked).n_models + 1
    with shared.Progress(options, 0, heavy=steps) as progress:
        return compare_families(
            result.points, orders=orders, progress=progress, defend=True, **asked, **given
        )


def _bad_points(options: argparse.Namespace, result: Comparison) -> OutlierStudy:
    """Look for bad points under the comparison's own settings."""
    from bayescal.api.outliers import outliers

    assert result.points is not None, "it was made from points"
    asked = result.settings
    with shared.Progress(options, 2 * len(result.axes)) as progress:
        return outliers(
            result.points,
            sorted({r.order for axis in result.axes.values() for r in axis.orders}),
            axis="both" if len(result.axes) > 1 else next(iter(result.axes)),
            sigma=asked.sigma,
            prior=asked.prior,
            tau=asked.tau,
            nu=asked.nu,
            bad_offset=asked.bad_offset,
            seed=asked.seed,
            progress=progress.named,
            **({} if options.ess is None else {"ess": options.ess}),
        )
