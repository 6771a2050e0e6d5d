"""Output of the commands that work on joint models."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bayescal.commands.output import code_of, publish

if TYPE_CHECKING:
    from bayescal.comparison.families import FamilyComparison


def deliver_families(
    options: argparse.Namespace,
    result: FamilyComparison,
    view: Callable[[FamilyComparison], Any],
) -> int:
    """Write and print a comparison of joint models; return the exit code."""

    def text() -> str:
        from bayescal.report.facts import dumps
        from bayescal.report.families_document import families_document

        return dumps(families_document(result, options.command_line))

    def write(folder: Path, text: str) -> None:
        from bayescal.report.families_run import write_families

        write_families(folder, result, text, force=options.force)

    publish(options, text, write, lambda: view(result))
    return code_of(sound=result.sound)
