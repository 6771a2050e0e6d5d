"""Browsers that fail in every way: one line, no half a PDF, no process left behind."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from bayescal.errors import OutputError
from bayescal.report.page.pdf import print_pdf

CREATED = "2026-01-01T00:00:00+00:00"
TO = 'for a in "$@"; do case $a in --print-to-pdf=*) out=${a#--print-to-pdf=};; esac; done\n'


def browser(folder, does):
    """A program that is called like a Chromium."""
    path = folder / "chromium"
    path.write_text("#!/bin/sh\n" + TO + does)
    path.chmod(0o755)
    return str(path)


@pytest.mark.parametrize(
    "does",
    [
        "echo no display >&2; exit 3",
        "kill -9 $$",
        ': >"$out"',
        "printf '%%PDF-1.4 half of it' >\"$out\"; exit 1",
        'mkdir "$out"',
    ],
)
def test_what_is_no_whole_pdf_is_refused(tmp_path, does):
    with pytest.raises(OutputError, match=r"no whole PDF; leave out --pdf, open the HTML report"):
        print_pdf("<p>page</p>", browser(tmp_path, does), CREATED)


def test_what_is_no_program_is_refused(tmp_path):
    path = tmp_path / "chromium"
    path.write_bytes(b"\x7fELF, but no more of it")
    path.chmod(0o755)
    with pytest.raises(OutputError, match=r"can't be run: .*; leave out --pdf"):
        print_pdf("<p>page</p>", str(path), CREATED)


def test_a_browser_that_hangs_is_ended_with_its_helpers(tmp_path):
    written = tmp_path / "helper"
    hangs = browser(tmp_path, f'sleep 600 & echo $! >"{written}"; wait')
    with pytest.raises(OutputError, match="took over 1 s to print"):
        print_pdf("<p>page</p>", hangs, CREATED, timeout=1.0)
    helper = int(written.read_text())
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline and _runs(helper):
        time.sleep(0.05)
    assert not _runs(helper)


def _runs(process):
    """Whether a process is there and no zombie whom nobody has asked after."""
    try:
        os.kill(process, 0)
        state = Path(f"/proc/{process}/stat").read_text(encoding="ascii")
    except (ProcessLookupError, FileNotFoundError):
        return False
    return state.rpartition(")")[2].split()[0] != "Z"
