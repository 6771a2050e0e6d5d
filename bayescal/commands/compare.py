"""``bayescal compare``: which polynomial order."""

from __future__ import annotations

import argparse
from typing import Any

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.families import add_families, families_of
from bayescal.commands.shared.many import POSE, compared, many_or_few
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import add_output, check_output, deliver
from bayescal.commands.shared.resume import resumable

DESCRIPTION = "Compare polynomial orders of r(x/z) and c(y/z), each sampled with emcee."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    shared.add_orders(parser)
    shared.add_axis(parser)
    option(
        parser,
        "--defend",
        "answer a referee too: leave-one-out, prior sensitivity, stability, orders beyond "
        "the range (some ten seconds more)",
    )
    add_families(parser, several=True)
    option(
        parser,
        "--no-families",
        "do not look whether another family or a free position is decisively better",
    )
    shared.add_points(parser)
    shared.add_model(parser)
    add_output(parser)


def run(options: argparse.Namespace) -> int:
    """Compare, print and write; return the exit code."""
    asked = families_of(options, "compare")
    if asked is not None:
        return _across_families(options, asked)
    check_output(options)
    axes, hint = shared.axes_of(options), not options.no_families
    heavy, how = axes * options.defend + hint, {"defend": options.defend, "hint": hint}
    with resumable(options) as resume:
        return deliver(options, compared(options, heavy=heavy, resume=resume, **how))


def _across_families(options: argparse.Namespace, asked: dict[str, Any]) -> int:
    """Compare families of joint models of r and c."""
    check_output(options)
    given = {name: value for name, value in shared.settings(options).items() if name != "axis"}
    how = {"defend": options.defend, **asked, **given}
    from bayescal.api.families import compare_families, family_request

    request = family_request(orders=shared.orders_of(options), **asked)
    each = POSE if request.moves else None
    with resumable(options) as resume:
        with (
            many_or_few(options, request.n_models, each) as points,
            shared.Progress(options, 0, heavy=request.n_models + 1) as progress,
        ):
            result = compare_families(points, progress=progress, resume=resume, **how)
        return deliver(options, result)
