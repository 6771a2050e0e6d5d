"""The page of the thesis data, made once, and a browser to look at it with."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, sync_playwright

from bayescal.comparison.results import Comparison
from bayescal.report.page.page import html, page_of
from bayescal.report.page.pdf import BROWSERS


@pytest.fixture(scope="session")
def thesis_page(thesis_defended: Comparison, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of the thesis data."""
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(html(page_of(thesis_defended, "bayescal report")), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of the system's Chromium: CI has one, elsewhere the tests of the page need one."""
    found = next((p for name in BROWSERS if (p := shutil.which(name))), None)
    if found is None:
        why = "no Chromium is on the PATH; install it (apt-get install chromium)"
        pytest.fail(why) if "CI" in os.environ else pytest.skip(why)
    return found


@pytest.fixture(scope="session")
def browser(chromium: str) -> Iterator[Browser]:
    """Headless Chromium."""
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield started
        started.close()
