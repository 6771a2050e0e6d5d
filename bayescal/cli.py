"""The command line: parse, call, print."""

from __future__ import annotations

import argparse
import dataclasses
import os
import shlex
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from bayescal import __version__
from bayescal.errors import BayescalError, InputError

if TYPE_CHECKING:
    from bayescal.comparison.results import Comparison
    from bayescal.points.correspondences import Correspondences

DONE, BAD_INPUT, NOT_SOUND = 0, 2, 3


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default those of the process.

    Returns
    -------
    int
        0 done; 2 bad usage or bad input; 3 done, but the draws did not converge
        or disagree with the closed form.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    options = _parser().parse_args(given)
    options.command_line = shlex.join(["bayescal", *given])
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    try:
        run: Callable[[argparse.Namespace], int] = options.run
        code = run(options)
        sys.stdout.flush()
    except BayescalError as error:
        print(f"bayescal: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_INPUT
    except BrokenPipeError:  # the reader of a pipe has had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except KeyboardInterrupt:
        print("bayescal: interrupted; nothing was written", file=sys.stderr)
        return 130
    return code


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="bayescal",
        description="Bayesian uncertainty analysis for camera calibration: "
        "compares polynomial orders of the world-to-pixel map, so that the choice can be defended.",
        epilog="exit codes: 0 done; 2 bad usage or input, nothing written; 3 done, but the draws "
        "did not converge or disagree with the closed form",
    )
    parser.add_argument("--version", action="version", version=f"bayescal {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)

    compare = commands.add_parser(
        "compare",
        help="compare polynomial orders",
        description="Compare polynomial orders of r(x/z) and c(y/z), each sampled with emcee.",
    )
    compare.add_argument(
        "--orders", type=_orders, default="1-5", metavar="K-L", help="such as 1-5 or 1,3,5 (1-5)"
    )
    compare.add_argument(
        "--axis", choices=("r", "c", "both"), default="both", help="which pixel axis (both)"
    )
    compare.set_defaults(run=_compare)

    fit = commands.add_parser(
        "fit",
        help="fit one model and print it in full",
        description="Fit one order per axis, sampled with emcee, and print the model in full.",
    )
    fit.add_argument("--order-r", type=int, metavar="K", help="order of r(x/z)")
    fit.add_argument("--order-c", type=int, metavar="K", help="order of c(y/z)")
    fit.set_defaults(run=_fit)

    for command in (compare, fit):
        _add_common(command)
    return parser


def _add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "points",
        nargs="?",
        metavar="POINTS",
        help="CSV or TSV with columns x,y,z,r,c and optionally label, group, sigma_r, sigma_c; "
        "- reads standard input; by default the bundled thesis data",
    )
    camera = parser.add_argument_group("camera")
    camera.add_argument("--setup", metavar="FILE.toml", help="camera position, image size, priors")
    camera.add_argument(
        "--camera-position",
        nargs=3,
        type=float,
        metavar=("X", "Y", "Z"),
        help="world units (0 0 0)",
    )
    camera.add_argument("--image-width", type=float, metavar="PX", help="image width, px")
    camera.add_argument("--image-height", type=float, metavar="PX", help="image height, px")
    camera.add_argument(
        "--c-from-bottom",
        action=argparse.BooleanOptionalAction,
        help="count c from the bottom: c = height - row",
    )
    model = parser.add_argument_group("model")
    model.add_argument(
        "--sigma",
        type=_sigma,
        metavar="inferred|PX",
        help="noise level: inferred from the residuals, or known, px (the file's sigma_r, sigma_c "
        "where it has them, else inferred)",
    )
    model.add_argument(
        "--prior",
        choices=("field", "flat", "stated"),
        help="of the coefficients (the setup's where it states one, else field)",
    )
    model.add_argument(
        "--tau",
        type=float,
        metavar="T",
        help="fix the strength of the non-linearity, a fraction of the image (inferred)",
    )
    run = parser.add_argument_group("run")
    run.add_argument("--seed", type=int, default=0, metavar="N", help="of all randomness (0)")
    run.add_argument(
        "--ess", type=int, default=4000, metavar="N", help="effective samples wanted (4000)"
    )
    output = parser.add_argument_group("output")
    output.add_argument(
        "--json", metavar="FILE|-", help="write the result document; - prints it instead of tables"
    )
    output.add_argument(
        "--out", metavar="DIR", help="write a run: result.json, draws (NetCDF), corner plots"
    )
    output.add_argument("--force", action="store_true", help="replace existing output")
    output.add_argument("--quiet", action="store_true", help="print no tables")
    output.add_argument(
        "--progress",
        action=argparse.BooleanOptionalAction,
        help="progress bar (on a terminal, after a second)",
    )


def _orders(text: str) -> list[int]:
    orders: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        ends = [first, last] if dash else [first]
        if not all(end.isascii() and end.isdigit() for end in ends):
            raise argparse.ArgumentTypeError(
                f"{text!r} is not a list of orders such as 1-5 or 1,3,5"
            )
        low, high = int(ends[0][:9]), int(ends[-1][:9])
        if high < low:
            raise argparse.ArgumentTypeError(f"{part.strip()!r} runs backwards; write {high}-{low}")
        orders.update(range(low, min(high, low + 1000) + 1))
    return sorted(orders)


def _sigma(text: str) -> float | str:
    if text == "inferred":
        return text
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is neither 'inferred' nor a number of px"
        ) from None


def _points(options: argparse.Namespace) -> Correspondences:
    from bayescal.points.bundled import thesis
    from bayescal.points.reader import load
    from bayescal.points.setup import load_setup

    setup = load_setup(options.setup) if options.setup is not None else None
    points = thesis() if options.points is None else load(options.points)
    base = setup if setup is not None else points.setup
    flags: dict[str, Any] = {
        "position": tuple(options.camera_position) if options.camera_position else None,
        "width": options.image_width,
        "height": options.image_height,
        "c_from_bottom": options.c_from_bottom,
    }
    changes = {name: value for name, value in flags.items() if value is not None}
    if changes:
        assumed = tuple(name for name in base.assumed if name not in changes)
        base = dataclasses.replace(base, **changes, assumed=assumed)
    return dataclasses.replace(points, setup=base)


def _compare(options: argparse.Namespace) -> int:
    from bayescal.api import compare
    from bayescal.report.terminal import comparison_view

    _check_output(options)
    points = _points(options)
    with _Progress(options, len(options.orders) * (2 if options.axis == "both" else 1)) as progress:
        result = compare(
            points, options.orders, axis=options.axis, progress=progress, **_settings(options)
        )
    return _deliver(options, result, comparison_view)


def _fit(options: argparse.Namespace) -> int:
    from bayescal.api import fit
    from bayescal.report.terminal import fit_view

    if options.order_r is None and options.order_c is None:
        raise InputError("fit: give --order-r, --order-c or both")
    _check_output(options)
    points = _points(options)
    with _Progress(options, 2) as progress:
        result = fit(
            points, options.order_r, options.order_c, progress=progress, **_settings(options)
        )
    return _deliver(options, result, fit_view)


def _settings(options: argparse.Namespace) -> dict[str, Any]:
    return {name: getattr(options, name) for name in ("sigma", "prior", "tau", "seed", "ess")}


def _check_output(options: argparse.Namespace) -> None:
    """Refuse output that can't be written before anything is computed."""
    if options.json not in (None, "-"):
        from bayescal.files import check_free

        check_free(Path(options.json), force=options.force)
    if options.out is not None:
        from bayescal.report.run import check_run

        check_run(Path(options.out), force=options.force)


def _deliver(
    options: argparse.Namespace, result: Comparison, view: Callable[[Comparison], Any]
) -> int:
    if options.json is not None or options.out is not None:
        from bayescal.report.document import document, dumps

        text = dumps(document(result, options.command_line))
        if options.out is not None:
            from bayescal.report.run import write_run

            write_run(Path(options.out), result, text, force=options.force)
        if options.json == "-":
            sys.stdout.write(text)
        elif options.json is not None:
            from bayescal.files import write_whole

            write_whole(Path(options.json), text.encode(), force=options.force)
    if not options.quiet and options.json != "-":
        from bayescal.report.terminal import render

        sys.stdout.write(render(view(result), terminal=sys.stdout.isatty()))
    if not result.sound:
        print(
            "bayescal: some draws did not converge or disagree with the closed form (exit code 3)",
            file=sys.stderr,
        )
        return NOT_SOUND
    return DONE


class _Progress:
    """A progress bar on a terminal, once a second has passed."""

    def __init__(self, options: argparse.Namespace, total: int) -> None:
        shown = options.progress
        if shown is None:
            shown = sys.stderr.isatty() and not options.quiet
        self._bar: Any = None
        if shown:
            from tqdm import tqdm

            self._bar = tqdm(total=total, unit="model", delay=1, leave=False, file=sys.stderr)

    def __call__(self, axis: str, order: int) -> None:
        if self._bar is not None:
            self._bar.set_description(f"sampling {axis}, order {order}", refresh=False)
            self._bar.update()

    def __enter__(self) -> _Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()
