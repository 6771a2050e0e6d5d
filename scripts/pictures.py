"""Takes pictures of a real report and of the table in a terminal."""

import io
import os
import shutil
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import Page, sync_playwright
from rich.console import Console
from rich.text import Text

import bayescal as bc
from bayescal.report.terminal import WIDTH, render
from bayescal.report.views.comparison import brief

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def main() -> int:
    """Make both pictures; 1 without a browser."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        print("pictures: no Chromium was found; install one", file=sys.stderr)
        return 1
    IMAGES.mkdir(exist_ok=True)
    flags = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        chromium = playwright.chromium.launch(executable_path=browser, args=flags)
        page = chromium.new_page(viewport={"width": 1024, "height": 1100})
        _report(page, Path(folder) / "report.html")
        _terminal(page)
        chromium.close()
    return 0


def _report(page: Page, place: Path) -> None:
    """Picture the top of the report of the thesis data."""
    bc.save_report(bc.compare(bc.thesis(), defend=True), place)
    page.goto(place.as_uri())
    page.screenshot(path=IMAGES / "report.png")


def _terminal(page: Page) -> None:
    """Picture what compare prints of r."""
    console = Console(record=True, width=WIDTH, file=io.StringIO(), force_terminal=True)
    shown = render(brief(bc.compare(bc.thesis(), axis="r")), terminal=True)
    console.print(Text.from_ansi(shown))
    svg = console.export_svg(title="bayescal compare --axis r")
    page.set_content(f"<body style='margin:0'>{svg}</body>")
    page.locator("svg").screenshot(path=IMAGES / "terminal.png")


if __name__ == "__main__":
    sys.exit(main())
