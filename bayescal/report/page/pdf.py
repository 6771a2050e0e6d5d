"""A page as PDF, printed by the Chromium that the machine has."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import subprocess
import tempfile
from datetime import datetime
from pathlib import Path

from bayescal.errors import OutputError

BROWSERS = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "msedge",
    "microsoft-edge",
)
TIMEOUT = 120.0  # seconds
INSTEAD = "leave out --pdf, open the HTML report in any browser and print it to PDF"
# What Chromium writes of the pages, and of the places on them that links lead to.
_NODES = re.compile(rb"(\d+) 0 obj\s<</Type /Pages\s[^>]*?/Kids \[([^\]]*)\]")
_PLACES = re.compile(rb"/(?!Dest )(\S+) \[(\d+) 0 R /XYZ")
_CITED = re.compile(r'data-of="([^"]+)">')
_DATES = re.compile(rb"/(CreationDate|ModDate) \(D:(\d{14})([+-]\d\d'\d\d')?\)")


def find_browser() -> str:
    """Find a Chromium on the PATH.

    Raises
    ------
    OutputError
        Where there is none; says how to get a PDF all the same.
    """
    for name in BROWSERS:
        found = shutil.which(name)
        if found is not None:
            return found
    raise OutputError(
        f"--pdf needs Chromium or Chrome on the PATH, and there is none; install it, or {INSTEAD}"
    )


def check_browser(browser: str) -> None:
    """Print one empty page, so that a browser that can't is known before any work is done.

    Raises
    ------
    OutputError
        As `print_pdf`.
    """
    print_pdf("<!DOCTYPE html><title>empty</title>", browser, "1970-01-01T00:00:00+00:00")


def print_pdf(page: str, browser: str, created: str, timeout: float = TIMEOUT) -> bytes:
    """Print a page on A4, the numbers of its pages in its contents.

    Browsers can't count ahead (``target-counter`` of CSS): it is printed once to learn on
    which page every chapter begins, and once more with these numbers.

    Parameters
    ----------
    page : str
        HTML.
    browser : str
        Path of a Chromium.
    created : str
        ISO 8601 time that the PDF states, so that it does not depend on the clock.
    timeout : float, optional
        Seconds.

    Raises
    ------
    OutputError
        Where the browser fails or takes too long; none of its processes is left.
    """
    made = printed(page, browser, timeout)
    if _CITED.search(page) is not None:
        made = printed(_with_pages(page, pages_of(made)), browser, timeout)
    return _dated(made, created)


def pages_of(made: bytes) -> dict[str, int]:
    """Find the pages that links lead to, by the ids of their places."""
    nodes = {n: re.findall(rb"(\d+) 0 R", kids) for n, kids in _NODES.findall(made)}
    (root,) = nodes.keys() - {kid for kids in nodes.values() for kid in kids}
    numbers = {n: i for i, n in enumerate(_leaves(root, nodes), 1)}
    return {place.decode(): numbers[n] for place, n in _PLACES.findall(made)}


def _leaves(node: bytes, nodes: dict[bytes, list[bytes]]) -> list[bytes]:
    """List the pages below a node of a PDF's tree of pages, in order."""
    if node not in nodes:
        return [node]
    return [leaf for kid in nodes[node] for leaf in _leaves(kid, nodes)]


def _with_pages(page: str, pages: dict[str, int]) -> str:
    """Fill the numbers of pages into a page's contents."""
    return _CITED.sub(lambda found: f"{found[0]}{pages.get(found[1], '')}", page)


def printed(page: str, browser: str, timeout: float) -> bytes:
    """Print a page once."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as temporary:
        folder = Path(temporary)
        source, out = folder / "report.html", folder / "report.pdf"
        source.write_text(page, encoding="utf-8")
        command = [
            browser,
            "--headless",
            "--disable-gpu",
            "--disable-extensions",
            "--disable-background-networking",
            "--no-first-run",
            f"--user-data-dir={folder / 'profile'}",
            "--no-pdf-header-footer",
            "--generate-pdf-document-outline",
            f"--print-to-pdf={out}",
            source.as_uri(),
        ]
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            command.insert(1, "--no-sandbox")  # Chromium refuses root its sandbox
        _run(command, timeout)
        made = out.read_bytes() if out.is_file() else b""
    if not (made.startswith(b"%PDF") and made.rstrip().endswith(b"%%EOF")):
        raise OutputError(f"{browser} printed no whole PDF; {INSTEAD}")
    return made


def _run(command: list[str], timeout: float) -> None:
    """Run a browser to its end, or end it with all the processes it has started."""
    try:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise OutputError(f"{command[0]} can't be run: {reason}; {INSTEAD}") from None
    try:
        process.wait(timeout)
    except subprocess.TimeoutExpired:
        raise OutputError(
            f"{command[0]} took over {timeout:g} s to print the PDF; {INSTEAD}"
        ) from None
    finally:  # a browser that ended by itself may leave helpers behind, too
        if hasattr(os, "killpg"):
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
        process.wait()


def _dated(raw: bytes, created: str) -> bytes:
    """Replace the times of printing by the report's own, of the same length."""
    stamp = datetime.fromisoformat(created).strftime("%Y%m%d%H%M%S").encode()

    def replaced(found: re.Match[bytes]) -> bytes:
        zone = b"+00'00'" if found[3] else b""
        return b"/%s (D:%s%s)" % (found[1], stamp, zone)

    return _DATES.sub(replaced, raw)
