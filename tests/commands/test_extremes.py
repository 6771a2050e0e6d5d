"""Inputs nobody thought of: a right result or one clear line, never anything in between."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from tests.helpers.command import here
from tests.helpers.points_files import HEADER, rows, text, write

ROWS = rows(20)
GOOD = text(ROWS)


def shaped(x: float = 1, y: float = 1, z: float = 1, pixel: float = 1) -> str:
    return text([(x * a, y * b, z * c, pixel * r, pixel * v) for a, b, c, r, v in ROWS])


def with_sigma(*values: float) -> str:
    table = [(*row, values[i % len(values)], 1) for i, row in enumerate(ROWS)]
    return text(table, f"{HEADER},sigma_r,sigma_c")


CASES: dict[str, tuple[str, list[str]]] = {
    "x of 1e-320": (text([(i * 1e-320, *row[1:]) for i, row in enumerate(ROWS)]), []),
    "x of 1e-99": (shaped(x=1e-102), []),
    "x of 1e-40": (shaped(x=1e-43), []),
    "x of 1e40": (shaped(x=1e37), []),
    "x of 1e99": (shaped(x=1e96), []),
    "z of 1e-99": (shaped(z=1e-102), []),
    "z of 1e99": (shaped(z=1e96), []),
    "z of 1e-320": (text([(a, b, 1e-320, r, c) for a, b, _, r, c in ROWS]), []),
    "world of 1e99": (shaped(1e96, 1e96, 1e96), []),
    "world of 1e-300": (shaped(1e-303, 1e-303, 1e-303), []),
    "pixels of 1e-320": (shaped(pixel=1e-323), []),
    "pixels of 1e-300": (shaped(pixel=1e-303), []),
    "pixels a thousand images away": (
        shaped(pixel=1e3), ["--image-width", "1920", "--image-height", "1080"],
    ),
    "pixels of 1e-99": (shaped(pixel=1e-102), []),
    "one pixel of 9e8": (f"{GOOD}1,1,5,9e8,-9e8\n", []),
    "one pixel of 9e8, image size known": (
        f"{GOOD}1,1,5,9e8,-9e8\n", ["--image-width", "1920", "--image-height", "1080"],
    ),
    "pixels of 9e8, image size known": (
        shaped(pixel=9e5), ["--image-width", "1920", "--image-height", "1080"],
    ),
    "r all zero": (text([(a, b, c, 0, v) for a, b, c, _, v in ROWS]), []),
    "sigma of 1e-6": (with_sigma(1e-6), []),
    "sigma from 1e-6 to 1e9": (with_sigma(1e-6, 1, 1e9), []),
    "one sigma of 1e-6": (with_sigma(1e-6, *[1.0] * 19), []),
    "one sigma of 1e9": (with_sigma(1e9, *[1.0] * 19), []),
    "all but one sigma of 1e9": (with_sigma(1, *[1e9] * 19), []),
    "known sigma of 1e-320": (GOOD, ["--sigma", "1e-320"]),
    "known sigma of 1e-300": (GOOD, ["--sigma", "1e-300"]),
    "known sigma of 1e-20": (GOOD, ["--sigma", "1e-20"]),
    "known sigma of 1e-9": (GOOD, ["--sigma", "1e-9"]),
    "known sigma of 1e-5": (GOOD, ["--sigma", "1e-5"]),
    "known sigma of 1e20": (GOOD, ["--sigma", "1e20"]),
    "known sigma of 1e300": (GOOD, ["--sigma", "1e300"]),
    "tau of 1e-320": (GOOD, ["--tau", "1e-320"]),
    "tau of 1e-300": (GOOD, ["--tau", "1e-300"]),
    "tau of 1e-100": (GOOD, ["--tau", "1e-100"]),
    "tau of 1e20": (GOOD, ["--tau", "1e20"]),
    "tau of 1e300": (GOOD, ["--tau", "1e300"]),
    "image of 1 px": (GOOD, ["--image-width", "1", "--image-height", "1"]),
    "image of 1e9 px": (GOOD, ["--image-width", "1e9", "--image-height", "1e9"]),
    "camera at 1e20, x": (GOOD, ["--camera-position", "1e20", "0", "0"]),
    "camera at -1e20, z": (GOOD, ["--camera-position", "0", "0", "-1e20"]),
    "camera at 1e99": (GOOD, ["--camera-position", "1e99", "1e99", "1e99"]),
    "camera on a point": (GOOD, ["--camera-position", *map(str, ROWS[0][:3])]),
    "camera that makes all x/z equal": (
        text([(7, b, c, r, v) for _, b, c, r, v in ROWS]), ["--camera-position", "7", "0", "0"],
    ),
    "seed of a hundred digits": (GOOD, ["--seed", "9" * 100]),
    "orders with a thousand digits": (GOOD, ["--orders", "1-" + "9" * 1000]),
    "arabic digits": (GOOD.replace("1", "\N{ARABIC-INDIC DIGIT ONE}"), []),
    "no-break blanks": (GOOD.replace(",", ",\u00a0"), []),
    "ten thousand comments": ("# nothing\n" * 10_000 + GOOD, []),
    "points of three planes": (
        text([(a, b, 500 * (1 + i % 3), r, v) for i, (a, b, _, r, v) in enumerate(ROWS)]), [],
    ),
}  # fmt: skip


def refuse_constant(name: str) -> Any:
    raise AssertionError(f"{name} in the document")


def numbers(node: Any) -> list[float]:
    if isinstance(node, dict):
        return [n for value in node.values() for n in numbers(value)]
    if isinstance(node, list):
        return [n for value in node for n in numbers(value)]
    return [node] if isinstance(node, float) else []


@pytest.mark.parametrize("name", CASES)
def test_a_result_or_one_clear_line(name: str, tmp_path: Path) -> None:
    content, options = CASES[name]
    points = write(tmp_path, content)
    done = here("compare", points, "--orders", "1-3", *options, "--ess", "100", "--json", "-")
    if done.code == 2:
        assert done.out == ""
        assert done.err.count("\n") == 1
        assert len(done.err) < 300 + len(str(points)) + len(" ".join(options))
        return
    assert done.code in (0, 3)
    assert done.err.count("\n") == (done.code == 3)
    document = json.loads(done.out, parse_constant=refuse_constant)
    assert all(math.isfinite(n) for n in numbers(document))
    for axis in document["axes"].values():
        chances = [order["probability"] for order in axis["orders"]]
        assert sum(chances) == pytest.approx(1)
        for order in axis["orders"]:
            assert order["rss_px2"] >= 0
            for summary in order["coefficients"]:
                assert summary["interval"][0] <= summary["mean"] <= summary["interval"][1]
                if done.code == 0:
                    assert summary["mean"] == pytest.approx(
                        summary["exact_mean"], abs=6 * summary["exact_sd"]
                    )


def test_verdicts_do_not_depend_on_the_units_of_the_world(tmp_path: Path) -> None:
    """x/z has none: powers of two change no digit."""
    found = []
    for factor in (1.0, 2.0**-40, 2.0**60):
        points = write(tmp_path, shaped(factor, factor, factor))
        done = here("compare", points, "--orders", "1-3", "--ess", "100", "--json", "-")
        document = json.loads(done.out)
        found.append((document["axes"], document["verdict"]))
    assert found[0] == found[1] == found[2]


def test_order_of_the_rows_changes_nothing_but_rounding(tmp_path: Path) -> None:
    evidences = []
    for table in (ROWS, ROWS[::-1]):
        done = here(
            "compare", write(tmp_path, text(table)), "--orders", "1-3", "--ess", "100",
            "--json", "-",
        )  # fmt: skip
        axes = json.loads(done.out)["axes"]
        evidences.append([o["log_evidence"] for a in axes.values() for o in a["orders"]])
    assert evidences[0] == pytest.approx(evidences[1], abs=1e-9)
