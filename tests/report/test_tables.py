"""What is printed stays within 100 columns and says numbers, whatever the input."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from bayescal.report.terminal import WIDTH
from bayescal.report.views.lenses.tables import SHOWN, lenses_table
from tests.helpers.command import Finished, here
from tests.helpers.points_files import HEADER, rows, text, write

NOT_A_NUMBER = re.compile(r"(?<![a-z])(nan|inf|infinity|none)(?![a-z])", re.IGNORECASE)
STATED = "[prior.r]\nmean = [960, 0, 0]\nsd = [960, 960, 9]\n" + (
    "[prior.c]\nmean = [540, 0, 0]\nsd = [540, 540, 1e-6]\n"
)
ROWS = rows(20)


def scaled(pixel: float, offset: float = 0.0) -> str:
    return text([(x, y, z, offset + pixel * r, offset + pixel * c) for x, y, z, r, c in ROWS])


# The points, and the options they are compared with.
CASES = {
    "thesis": ("", ["--orders", "1-5"]),
    "thesis at order 12": ("", ["--orders", "1-12"]),
    "thesis at order 20": ("", ["--orders", "19,20", "--axis", "r"]),
    "two points": (text(rows(2)), ["--orders", "1"]),
    "two points, flat prior": (text(rows(2)), ["--orders", "1", "--prior", "flat"]),
    "two points, known sigma": (text(rows(2)), ["--orders", "1", "--sigma", "1"]),
    "three points": (text(rows(3)), ["--orders", "1-2"]),
    "three points, flat prior": (text(rows(3)), ["--orders", "1-2", "--prior", "flat"]),
    "four points, as many coefficients": (text(rows(4)), ["--orders", "1-3"]),
    "exact fit": (text(rows(20, noise=0)), ["--orders", "1-3"]),
    "exact fit, flat prior": (text(rows(20, noise=0)), ["--orders", "1-2", "--prior", "flat"]),
    "exact fit, known sigma": (text(rows(20, noise=0)), ["--orders", "1-2", "--sigma", "1"]),
    "pixels all the same": (scaled(0, 7), ["--orders", "1-2"]),
    "pixels all zero": (scaled(0), ["--orders", "1-2"]),
    "pixels of 1e-9": (scaled(1e-12), ["--orders", "1-2"]),
    "pixels of 1e5": (scaled(100), ["--orders", "1-3"]),
    "pixels of 1e8": (scaled(1e5), ["--orders", "1-3"]),
    "pixels far from zero": (scaled(1, 1e8), ["--orders", "1-3"]),
    "one wild pixel": (f"{scaled(1)}1,1,5,1e6,-1e6\n", ["--orders", "1-3"]),
    "points behind the camera": (
        text([(x, y, -z, r, c) for x, y, z, r, c in ROWS]), ["--orders", "1-3"],
    ),
    "every point twice": (text(ROWS + ROWS), ["--orders", "1-3"]),
    "collinear": (text([(i, i, 1, 500 + i, 500 + i) for i in range(20)]), ["--orders", "1-3"]),
    "minus zero": (f"{text(ROWS)}-0.0,-0.0,1,-0.0,-0.0\n", ["--orders", "1-3"]),
    "tiny field of view": (
        text([(1e-9 * x, 1e-9 * y, z, r, c) for x, y, z, r, c in ROWS]), ["--orders", "1-3"],
    ),
    "wide field of view": (
        text([(1e9 * x, 1e9 * y, z, r, c) for x, y, z, r, c in ROWS]), ["--orders", "1-3"],
    ),
    "known sigma": (text(ROWS), ["--orders", "1-3", "--sigma", "0.8"]),
    "known sigma far too small": (text(ROWS), ["--orders", "1-3", "--sigma", "0.01"]),
    "known sigma of 1e-6": (text(rows(20, noise=1e-6)), ["--orders", "1-3", "--sigma", "1e-6"]),
    "known sigma far too large": (text(ROWS), ["--orders", "1-3", "--sigma", "1e6"]),
    "sigma per point": (
        text([(*row, 0.5 + i, 2) for i, row in enumerate(ROWS)], f"{HEADER},sigma_r,sigma_c"),
        ["--orders", "1-3"],
    ),
    "sigma per point from 1e-3 to 1e6": (
        text([(*row, 10 ** (i % 10 - 3), 1) for i, row in enumerate(ROWS)],
             f"{HEADER},sigma_r,sigma_c"),
        ["--orders", "1-3"],
    ),
    "flat prior": (text(ROWS), ["--orders", "1-3", "--prior", "flat"]),
    "stated prior": (text(ROWS), ["--orders", "1-2", "--setup", "setup.toml"]),
    "tau of 1e-9": (text(ROWS), ["--orders", "1-3", "--tau", "1e-9"]),
    "tau of 1e6": (text(ROWS), ["--orders", "1-3", "--tau", "1e6"]),
}  # fmt: skip


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Finished]:
    """What each case's comparison ends with; each is run once."""
    done: dict[str, Finished] = {}

    def run(name: str) -> Finished:
        if name not in done:
            content, options = CASES[name]
            folder = tmp_path_factory.mktemp("case")
            (folder / "setup.toml").write_text(STATED)
            options = [o.replace("setup.toml", str(folder / "setup.toml")) for o in options]
            points = [write(folder, content)] if content else []
            done[name] = here("compare", *points, *options, "--ess", "100")
        return done[name]

    return run


def check(done: Finished) -> None:
    assert (done.code, done.err) == (0, "")
    lines = done.out.splitlines()
    assert max(map(len, lines)) <= WIDTH == 100
    assert NOT_A_NUMBER.findall(done.out) == []
    assert all(line == line.rstrip() for line in lines)


@pytest.mark.parametrize("name", CASES)
def test_comparison_is_printed_within_100_columns(
    name: str, finished: Callable[[str], Finished]
) -> None:
    check(finished(name))
    axes = re.findall(r"Verdict on ([rc]): (\S.*)", finished(name).out)
    assert len(axes) == (1 if "--axis" in CASES[name][1] else 2)


@pytest.mark.parametrize("name", CASES)
def test_no_number_is_cut_short(name: str, finished: Callable[[str], Finished]) -> None:
    cut = [line for line in finished(name).out.splitlines() if "…" in line]
    assert cut == []


@pytest.mark.parametrize(
    "name", ["two points", "exact fit", "pixels of 1e8", "sigma per point", "flat prior"]
)
def test_one_model_in_full(name: str, tmp_path: Path) -> None:
    content, options = CASES[name]
    done = here(
        "fit", write(tmp_path, content), "--order-r", "1", "--order-c", "1", "--ess", "100",
        *options[2:],
    )  # fmt: skip
    check(done)
    assert done.out.count("without sampling") == 2


def test_the_recommended_order_is_marked_once_per_table(
    finished: Callable[[str], Finished],
) -> None:
    done = finished("thesis")
    marked = re.findall(r"^ > +(\d+) ", done.out, re.MULTILINE)
    assert marked == ["4", "1"]
    assert "Verdict on r: Order 4" in done.out
    assert "Verdict on c: Order 1" in done.out


def test_a_flat_prior_recommends_nothing(finished: Callable[[str], Finished]) -> None:
    done = finished("flat prior")
    assert re.findall(r"^ >", done.out, re.MULTILINE) == []
    assert len(re.findall("Verdict on [rc]: No order is recommended", done.out)) == 2


def test_a_long_name_is_wrapped_not_cut(tmp_path: Path) -> None:
    name = "n" * 200 + ".csv"
    done = here("compare", write(tmp_path, text(ROWS), name), "--orders", "1", "--ess", "100")
    check(done)
    assert name in "".join(done.out.split())


def test_markup_in_a_name_is_only_a_name(tmp_path: Path) -> None:
    name = "[red]points[bold].csv"
    done = here("compare", write(tmp_path, text(ROWS), name), "--orders", "1", "--ess", "100")
    check(done)
    assert name in "".join(done.out.split())


def test_lenses_that_the_first_table_leaves_out_stand_in_the_second(lens_comparison):
    """Truth: all rows of both tables are the lenses, each once; the best one alone is marked."""
    lenses = [
        dataclasses.replace(lens_comparison.best, log_evidence=-float(i)) for i in range(SHOWN + 3)
    ]
    found = dataclasses.replace(lens_comparison, lenses=tuple(lenses))
    first = lenses_table(found, found.lenses[:SHOWN])
    rest = lenses_table(found, found.lenses[SHOWN:])
    at = [column.head for column in first.columns].index("ln Z")
    assert [float(row[at].value) for row in (*first.rows, *rest.rows)] == [
        -float(i) for i in range(SHOWN + 3)
    ]
    assert (first.marked, rest.marked) == (0, None)
