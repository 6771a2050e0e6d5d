"""Running the command, in this process or in one of its own."""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import bayescal as bc
from bayescal.cli import main


class Finished(NamedTuple):
    """What a command left behind."""

    code: int
    out: str
    err: str


def here(*arguments: str | Path) -> Finished:
    """Run the command in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main([str(a) for a in arguments])
        except SystemExit as stop:  # how argparse leaves
            code = int(stop.code or 0)
    return Finished(code, out.getvalue(), err.getvalue())


def environment(**more: str) -> dict[str, str]:
    """Environment in which a process of its own finds the package under test."""
    return {**os.environ, "PYTHONPATH": str(Path(bc.__file__).resolve().parents[1]), **more}


def apart(
    *arguments: str | Path, folder: Path, stdin: bytes = b"", **variables: str
) -> subprocess.CompletedProcess[bytes]:
    """Run the command in a process of its own, where every warning is an error."""
    return subprocess.run(
        [sys.executable, "-W", "error", "-m", "bayescal", *map(str, arguments)],
        cwd=folder,
        env=environment(**variables),
        input=stdin,
        capture_output=True,
    )
