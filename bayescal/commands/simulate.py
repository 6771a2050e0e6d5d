"""``bayescal simulate``: points from a known truth, to try the verdict on."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import DONE, check_file
from bayescal.errors import InputError

if TYPE_CHECKING:
    from bayescal.points.correspondences import Correspondences
    from bayescal.points.setup import Setup
    from bayescal.simulation import Truth

DESCRIPTION = (
    "Make points whose orders, coefficients and noise are known, to try the verdict on. The truth "
    "stands in the file as comments. Unless --like is given the world points are drawn in front "
    "of the camera: x/z uniform from -0.6 to 0.6, y/z from -0.35 to 0.35, z from 300 to 1500 "
    "world units."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    truth = parser.add_argument_group("truth")
    option(truth, "--order K", "order of r(x/z) and of c(y/z)", int)
    option(truth, "--order-r K", "order of r, where it differs", int)
    option(truth, "--order-c K", "order of c, where it differs", int)
    option(truth, "--sigma PX", "noise of each pixel (1 px)", float, default=1.0)
    option(
        truth,
        "--tau T",
        "strength of the non-linearity, a fraction of the image: the coefficients are drawn "
        "from the field prior with it (0.02)",
        float,
    )
    for name, axis, regressor in (("alpha", "r", "x/z"), ("beta", "c", "y/z")):
        option(
            truth,
            f"--{name} PX",
            f"coefficients of {axis} in place of drawn ones, of ({regressor})^0, "
            f"({regressor})^1, ...",
            float,
            nargs="+",
        )
    layout = parser.add_argument_group("points")
    option(layout, "--n N", "how many (as many as --like has, else 57)", int)
    option(
        layout,
        "--like POINTS",
        "take the world points of this file (of the bundled thesis data where none is named): "
        "all of them as often as N allows, and for the rest some at random",
        nargs="?",
        const="",
    )
    option(
        layout,
        "--setup FILE.toml",
        "the camera (at 0 0 0, image 1920 by 1080 px, c from the bottom; the thesis's with "
        "its points; state it with --like POINTS)",
    )
    option(layout, "--seed N", "seed of the random numbers (0)", int, default=0)
    output = parser.add_argument_group("output")
    option(output, "--out FILE.csv", "write the points there (they are printed)")
    option(output, "--force", "replace existing output")


def run(options: argparse.Namespace) -> int:
    """Simulate, then print the points or write them; return the exit code."""
    coefficients = {a: v for a, v in (("r", options.alpha), ("c", options.beta)) if v is not None}
    orders = _orders(options, coefficients)
    if options.seed < 0:
        raise InputError(f"seed must not be negative, but is {options.seed}")
    from bayescal.files import write_whole

    if options.out == "-":
        options.out = None
    if options.out is not None:
        check_file(options, Path(options.out))
    import numpy as np

    from bayescal.points.setup_file import load_setup
    from bayescal.points.writer import to_csv
    from bayescal.simulation import simulate

    points, truth = simulate(
        orders,
        options.sigma,
        np.random.default_rng(options.seed),
        n=options.n,
        like=_like(options.like),
        setup=load_setup(options.setup) if options.setup is not None else None,
        tau=options.tau,
        coefficients=coefficients,
    )
    compare = _compare(options, points.setup)
    told = _told(truth, repr)
    comments = [f"simulated by: {options.command_line}", *told, f"compare with: {compare}"]
    text = "".join(f"# {_printable(line)}\n" for line in comments) + to_csv(points)
    if options.out is None:
        sys.stdout.write(text)
    else:
        write_whole(Path(options.out), text.encode(), force=options.force)
        from bayescal.report.blocks import Listing
        from bayescal.report.terminal import printed

        short = tuple(map(str.strip, _told(truth, "{:.6g}".format)))
        text = printed((Listing(short, "about"),))
        print(f"{len(points)} points in {options.out}\n{text}\n{compare}")
    return DONE


def _orders(options: argparse.Namespace, given: dict[str, list[float]]) -> dict[str, int]:
    """Order of each axis, whose own option comes before --order."""
    orders = {}
    for axis, own, name in (("r", options.order_r, "alpha"), ("c", options.order_c, "beta")):
        order = options.order if own is None else own
        if axis in given:
            stated = len(given[axis]) - 1
            if own is not None and own != stated:
                raise InputError(
                    f"--{name} has {stated + 1} coefficients, which is order {stated}, not "
                    f"{own}; leave out --order-{axis}"
                )
            order = stated
        if order is None:
            raise InputError(f"the order of {axis} is not given; give --order K")
        orders[axis] = order
    return orders


def _like(name: str | None) -> Correspondences | None:
    """Points to take the layout of; the thesis's where only the option stands."""
    from bayescal.points.bundled import thesis
    from bayescal.points.reader import load

    if name is None:
        return None
    return load(name) if name else thesis()


def _told(truth: Truth, number: Callable[[float], str]) -> list[str]:
    """Lines that say what the points were made with, coefficients written by `number`."""
    from bayescal.polynomials.pixel_axis import PIXEL_AXES

    lines = []
    for axis, t in truth.axes.items():
        strength = f", tau {t.tau:g}" if t.tau is not None else ""
        lines.append(f"truth of {axis}: order {t.order}, sigma {t.sigma:g} px{strength}")
        values = ", ".join(map(number, t.coefficients.tolist()))
        lines.append(f"  {PIXEL_AXES[axis].symbol}, px, of ({t.regressor})^0, ^1, ...: {values}")
        ends = f"{t.domain.lower:.4g} to {t.domain.upper:.4g}"
        values = ", ".join(f"{v:.4g}" for v in t.amplitudes.tolist())
        lines.append(f"  px that each order adds at the edge of {t.regressor}, {ends}: {values}")
    return lines


def _compare(options: argparse.Namespace, setup: Setup) -> str:
    """Command that compares the points, with the camera they were made with."""
    words = ["bayescal", "compare", options.out if options.out is not None else "FILE.csv"]
    if options.setup is not None:
        return shlex.join([*words, "--setup", options.setup])
    words += ["--camera-position", *(f"{v!r}".removesuffix(".0") for v in setup.position)]
    for side, size in (("width", setup.width), ("height", setup.height)):
        if size is not None:
            words += [f"--image-{side}", f"{size!r}".removesuffix(".0")]
    return shlex.join([*words, *(["--c-from-bottom"] if setup.c_from_bottom else [])])


def _printable(line: str) -> str:
    """Keep a comment on its line, whatever a file is called."""
    return "".join(c if c.isprintable() else "?" for c in line)
