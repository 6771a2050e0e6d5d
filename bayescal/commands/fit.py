"""``bayescal fit``: one model in full."""

from __future__ import annotations

import argparse
from pathlib import Path

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.families import add_families
from bayescal.commands.shared.many import POSE, many_or_few
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import add_output, check_file, check_output, deliver
from bayescal.errors import InputError

DESCRIPTION = "Fit one order per axis, sampled with emcee, and print the model in full."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    option(parser, "--order-r K", "order of r(x/z)", int)
    option(parser, "--order-c K", "order of c(y/z)", int)
    add_families(parser, several=False)
    option(parser, "--order K", "of bivariate or pinhole: degree or coefficients", int)
    option(parser, "--opencv FILE", "write a pinhole as OpenCV's camera (YAML, cv2.FileStorage)")
    shared.add_points(parser)
    shared.add_model(parser)
    add_output(parser)


def run(options: argparse.Namespace) -> int:
    """Fit, print and write; return the exit code."""
    if options.radial is not None and options.family != "pinhole":
        raise InputError("--radial belongs to a pinhole: add --family pinhole, or leave it out")
    if options.family is not None or options.position is not None:
        return _joint(options)
    if options.opencv is not None:
        raise InputError("--opencv belongs to a pinhole: add --family pinhole")
    if options.order_r is None and options.order_c is None:
        raise InputError("fit: give --order-r, --order-c or both")
    from bayescal.api.axes import fit

    check_output(options)
    models = (options.order_r is not None) + (options.order_c is not None)
    with many_or_few(options, models) as points, shared.Progress(options, models) as progress:
        result = fit(
            points,
            options.order_r,
            options.order_c,
            progress=progress,
            **shared.settings(options),
        )
    return deliver(options, result, full=True)


def _joint(options: argparse.Namespace) -> int:
    """Fit one joint model of r and c."""
    from bayescal.api.families import fit_family

    family = options.family or "separable"
    if family == "separable":
        wanted: tuple[int, ...] = (options.order_r, options.order_c)
        if None in wanted or options.order is not None:
            raise InputError("fit: give --order-r and --order-c of the separable family")
    else:
        wanted = (options.order,)
        if options.order is None:
            raise InputError(f"fit: give --order of the {family} family")
    if options.position is not None and len(options.position) != 1:
        raise InputError("fit: give one --position, stated or free")
    check_output(options)
    if options.opencv is not None:
        from bayescal.report.opencv import check_opencv

        check_opencv(family, wanted[0], options.radial or "even")
        if options.opencv in ("", "-"):
            raise InputError("--opencv: name a file")
        place = Path(options.opencv)
        check_file(options, place)
        if options.json not in (None, "-") and place.resolve() == Path(options.json).resolve():
            raise InputError("--json and --opencv name the same file; name two")
    moves = family == "pinhole" or options.position == ["free"]
    with many_or_few(options, 1, POSE if moves else None) as points:
        result = fit_family(
            points,
            family,
            wanted,
            position=None if options.position is None else options.position[0],
            radial=options.radial or "even",
            **shared.settings(options),
        )
    code = deliver(options, result, full=True)
    if options.opencv is not None:
        from bayescal.report.opencv import save_opencv

        save_opencv(result, options.opencv, force=options.force)
    return code
