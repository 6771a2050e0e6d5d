"""The page on paper, and the command that writes both."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from bayescal.errors import OutputError
from bayescal.report.page.pdf import find_browser, pages_of, print_pdf, printed
from tests.helpers.command import here

CREATED = "2026-01-02T03:04:05+00:00"


def test_pages_text_and_date(chromium: str, thesis_page: Path):
    made = print_pdf(thesis_page.read_text(encoding="utf-8"), chromium, CREATED)
    assert made.startswith(b"%PDF")
    assert 8 <= len(re.findall(rb"/Type\s*/Page\b", made)) <= 26
    dates = re.findall(rb"/(?:CreationDate|ModDate) \(D:(\d+)", made)
    assert dates
    assert set(dates) == {b"20260102030405"}


def test_contents_name_the_pages_that_chapters_begin_on(chromium: str):
    """Twenty chapters, each on a page of its own but for two that share the second page."""
    breaks = ["page"] * 20
    breaks[2] = "auto"
    links = "".join(f'<a href="#c{i}">.</a><b data-of="c{i}"></b>' for i in range(20))
    parts = [f'<h2 id="c{i}" style="break-before:{how}">{i}</h2>' for i, how in enumerate(breaks)]
    made = printed(f"<!DOCTYPE html><nav>{links}</nav>{''.join(parts)}", chromium, 60.0)
    found = {f"c{i}": i + 2 - (i > 1) for i in range(20)}
    assert pages_of(made) == found


def test_no_browser_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(OutputError, match="install it"):
        find_browser()
    page, pdf = tmp_path / "a.html", tmp_path / "a.pdf"
    done = here("report", "--orders", "1", "--out", page, "--pdf", pdf)
    assert done.code == 2
    assert done.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_browser_that_fails_is_said():
    broken = shutil.which("false")
    assert broken is not None
    with pytest.raises(OutputError, match="printed no whole PDF"):
        print_pdf("<p>", broken, CREATED)


def test_a_browser_that_cannot_print_is_said_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("PATH", str(_browser(tmp_path, "exit 1").parent))
    page, pdf = tmp_path / "a.html", tmp_path / "a.pdf"
    # Orders no points can determine: an analysis would have complained of them.
    done = here("report", "--orders", "20", "--out", page, "--pdf", pdf)
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert "printed no whole PDF" in done.err
    assert not page.exists()


def test_a_browser_that_dies_later_leaves_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, chromium: str
):
    mark = tmp_path / "used"
    once = f'if [ -e "{mark}" ]; then exit 1; fi; : > "{mark}"; exec "{chromium}" "$@"'
    found = _browser(tmp_path, once)
    monkeypatch.setenv("PATH", str(found.parent), prepend=":")
    page, pdf = tmp_path / "a.html", tmp_path / "a.pdf"
    options = ("--orders", "1", "--axis", "c", "--ess", "200")
    done = here("report", *options, "--out", page, "--pdf", pdf)
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert f"{page} is written" in done.err
    assert "</html>" in page.read_text(encoding="utf-8")
    assert not pdf.exists()


def _browser(folder: Path, does: str) -> Path:
    """Put a program of a browser's name into a folder of its own."""
    (folder / "programs").mkdir()
    made = folder / "programs" / "chromium"
    made.write_text(f"#!/bin/sh\n{does}\n")
    made.chmod(0o755)
    return made


def test_a_run_gives_page_and_pdf(tmp_path: Path):
    run, page, pdf = tmp_path / "run", tmp_path / "a.html", tmp_path / "a.pdf"
    options = ["--orders", "1", "--axis", "c", "--ess", "400", "--quiet"]
    assert here("compare", *options, "--out", run).code == 0
    done = here("report", run, "--out", page, "--pdf", pdf)
    assert done.code == 0, done.err
    assert "order 1" in done.out
    assert pdf.read_bytes().startswith(b"%PDF")
    assert here("report", run, "--out", page).code == 2
    text = shutil.which("pdftotext")
    if text is not None:
        read = subprocess.run([text, pdf, "-"], capture_output=True, text=True, check=True)
        assert "Verdict" in read.stdout
