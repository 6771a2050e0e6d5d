"""Points read in chunks.

Truth: the points the files were made of, the complaints of the reader that reads at once, and
for the sample the share that each point should have of many draws.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2

import bayescal as bc
from bayescal.errors import InputError
from bayescal.points.chunks import stored, text
from bayescal.points.chunks.chunk import HELD, Lazily
from bayescal.points.chunks.drawn import Drawn
from bayescal.points.chunks.many import ManyPoints, many_points
from bayescal.points.chunks.tally import Tally
from tests.helpers.points_files import rows
from tests.helpers.points_files import text as table_of

N = HELD + 1000
TABLE = np.array(rows(N))
NAMES = [f"P{i}" for i in range(1, N + 1)]
FIELDS = [[*row, name, f"g{i % 7}"] for i, (row, name) in enumerate(zip(TABLE, NAMES, strict=True))]
FRAME = pd.DataFrame(TABLE, columns=["x", "y", "z", "r", "c"]).assign(sigma_r=0.5, label=NAMES)


def csv(path: Path) -> None:
    path.write_text(table_of(TABLE.tolist()))


def named(path: Path) -> None:
    path.write_text(table_of(FIELDS, "E,N,h,col,row,name,group", ";"))


def continental(path: Path) -> None:
    path.write_text(table_of(TABLE.tolist(), separator=";").replace(".", ","))


def blanks(path: Path) -> None:
    path.write_text("# made by hand\n" + table_of(TABLE.tolist(), separator="   ", end="\r\n"))


def commented(path: Path) -> None:
    """Comments and blank lines, which the quick way leaves to the patient one."""
    lines = table_of(TABLE.tolist()).split("\n")
    path.write_text("\n".join([*lines[:700], "# a pause", "", *lines[700:]]))


def npy(path: Path) -> None:
    with path.open("wb") as stream:
        np.save(stream, TABLE)


def columns_first(path: Path) -> None:
    with path.open("wb") as stream:
        np.save(stream, np.asfortranarray(TABLE))


def fields(path: Path) -> None:
    with path.open("wb") as stream:
        np.save(stream, FRAME.drop(columns="label").to_records(index=False))


def parquet(path: Path) -> None:
    FRAME.to_parquet(path)


FORMS = [csv, named, continental, blanks, commented, npy, columns_first, fields, parquet]


def many(source: object) -> ManyPoints:
    found = many_points(source)
    assert found is not None
    return found


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Several chunks of a few thousand points."""
    monkeypatch.setattr(stored, "ROWS", 900)
    monkeypatch.setattr(text, "BYTES", 60_000)
    monkeypatch.setattr(text, "HEAD", 30_000)


@pytest.mark.parametrize("form", FORMS)
def test_chunks_hold_every_point_once(form: Callable[[Path], None], tmp_path: Path) -> None:
    path = tmp_path / "points"
    form(path)
    chunks = list(many(path))
    assert len(chunks) > 3
    assert abs(many(path).found.about / N - 1) < 0.05
    found = np.concatenate([np.column_stack([c.world, c.pixels]) for c in chunks])
    np.testing.assert_array_equal(found, TABLE)
    at_once = bc.load(path)
    assert many(path).digest() == at_once.sha256
    assert many(path).found.notes == at_once.notes
    assert [label for c in chunks for label in c.labels] == list(at_once.labels)
    assert [g for c in chunks for g in c.groups or ()] == list(at_once.groups or ())
    places = [c.place(i) for c in chunks for i in range(len(c))]
    if form not in (npy, columns_first, fields, parquet):
        assert places == [at_once.place(i) for i in range(N)]
    if "sigma_r" in many(path).found.columns:
        assert all((c.sigma["r"] == 0.5).all() for c in chunks)


@pytest.mark.parametrize("form", FORMS)
def test_gathered_they_are_those_read_at_once(form: Callable[[Path], None], tmp_path: Path) -> None:
    path = tmp_path / "points"
    form(path)
    found, expected = many(path).at_once(), bc.load(path)
    np.testing.assert_array_equal(found.world, expected.world)
    np.testing.assert_array_equal(found.pixels, expected.pixels)
    assert set(found.sigma) == set(expected.sigma)
    for name, sd in expected.sigma.items():
        np.testing.assert_array_equal(found.sigma[name], sd)
    assert list(found.labels) == list(expected.labels)
    assert found.groups == expected.groups
    assert (found.source, found.sha256, found.notes) == (
        expected.source,
        expected.sha256,
        expected.notes,
    )
    if form not in (npy, columns_first, fields, parquet):
        assert [found.place(i) for i in range(N)] == [expected.place(i) for i in range(N)]


def test_more_than_can_be_held_are_refused(tmp_path: Path) -> None:
    csv(tmp_path / "points.csv")
    with pytest.raises(InputError, match=r"points.csv: holds more than 5999 points, the most for"):
        many(tmp_path / "points.csv").at_once(N - 1)


@pytest.mark.parametrize("form", [csv, npy, parquet])
def test_few_points_are_read_at_once(
    form: Callable[[Path], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (stored, text):
        monkeypatch.setattr(module, "HELD", N)
    form(tmp_path / "points")
    assert many_points(tmp_path / "points") is None


def test_arrays_and_correspondences_are_cut(tmp_path: Path) -> None:
    csv(tmp_path / "points.csv")
    for source in (TABLE, bc.load(tmp_path / "points.csv")):
        found = np.concatenate([np.column_stack([c.world, c.pixels]) for c in many(source)])
        np.testing.assert_array_equal(found, TABLE)
    assert many_points(TABLE[:HELD]) is None
    assert many_points("-") is None
    assert many_points(tmp_path / "nothing.csv") is None


WRONG = {
    "1.5,x2,900,3,4": "'x2' where a number should be",
    "1.5,2,900,3": "has 4 fields",
    "1.5,2,900,3,4,5": "has 6 fields",
    "1.5,nan,900,3,4": "is nan",
    "1.5,2,900,1e300,4": "no pixel is that far out",
}


@pytest.mark.parametrize("line", WRONG)
def test_a_wrong_line_is_named(line: str, tmp_path: Path) -> None:
    """In the words of the reader that reads at once."""
    lines = table_of(TABLE.tolist()).split("\n")
    lines[N - 10] = line
    path = tmp_path / "points.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=WRONG[line]) as caught:
        list(many(path))
    with pytest.raises(InputError) as expected:
        bc.load(path)
    assert str(caught.value) == str(expected.value)
    assert f"points.csv:{N - 9}:" in str(caught.value)


def test_a_line_that_is_no_text_is_named(tmp_path: Path) -> None:
    lines = table_of(TABLE.tolist()).encode().split(b"\n")
    lines[N - 10] = b"1,2,3,4,\xff"
    (tmp_path / "points.csv").write_bytes(b"\n".join(lines))
    with pytest.raises(InputError, match=f"points.csv:{N - 9}: is not UTF-8"):
        list(many(tmp_path / "points.csv"))


def test_a_wrong_row_of_an_array_is_named(tmp_path: Path) -> None:
    table = TABLE.copy()
    table[N - 1, 3] = np.nan
    np.save(tmp_path / "points.npy", table)
    with pytest.raises(InputError, match=rf"points.npy, point {N}: r: is nan"):
        list(many(tmp_path / "points.npy"))
    np.save(tmp_path / "other.npy", TABLE[:, :4])
    with pytest.raises(InputError, match=r"holds an array \(6000, 4\)"):
        many_points(tmp_path / "other.npy")
    whole = (tmp_path / "points.npy").read_bytes()
    (tmp_path / "cut.npy").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="is cut off"):
        list(many(tmp_path / "cut.npy"))


def test_words_in_a_column_of_parquet_are_refused(tmp_path: Path) -> None:
    FRAME.assign(r="far").to_parquet(tmp_path / "points.parquet")
    with pytest.raises(InputError, match=r"rows 1 to 900: r: .*far"):
        list(many(tmp_path / "points.parquet"))


def test_a_sample_has_the_points_in_their_order(tmp_path: Path) -> None:
    named(tmp_path / "points")
    drawn = Drawn(np.random.default_rng(0), 50)
    for chunk in many(tmp_path / "points"):
        drawn.add(chunk)
    points = drawn.points("", ())
    places = [int(label[1:]) - 1 for label in points.labels]
    assert len(set(places)) == 50
    assert places == sorted(places)
    assert points.drawn_from == N
    assert points.groups == tuple(f"g{i % 7}" for i in places)
    assert points.lines == tuple(i + 2 for i in places)
    np.testing.assert_array_equal(np.column_stack([points.world, points.pixels]), TABLE[places])


def test_every_point_is_as_likely_to_be_drawn() -> None:
    """Chi-squared of how often each of 40 points is among 10, drawn 2000 times from 4 chunks."""
    counts, rng = np.zeros(40), np.random.default_rng(0)
    made = bc.Correspondences.from_arrays(TABLE[:40, :3], TABLE[:40, 3:])
    chunks = [
        bc.Correspondences(made.world[p], made.pixels[p], made.labels[p])
        for p in (slice(0, 3), slice(3, 20), slice(20, 21), slice(21, 40))
    ]
    for _ in range(2000):
        drawn = Drawn(rng, 10)
        for chunk in chunks:
            drawn.add(chunk)
        counts[[int(label) - 1 for label in drawn.points("", ()).labels]] += 1
    # Without replacement: the variance of a count is 2000 / 4 * 3 / 4.
    statistic = ((counts - 500) ** 2).sum() / 375 * 39 / 40
    assert 0.001 < chi2.sf(statistic, 39) < 0.999


def test_memory_does_not_grow_with_the_points(tmp_path: Path) -> None:
    peaks = []
    for times in (5, 10):
        np.save(tmp_path / "points.npy", np.tile(TABLE, (times, 1)))
        tracemalloc.start()
        drawn = Drawn(np.random.default_rng(0))
        for chunk in many(tmp_path / "points.npy"):
            drawn.add(chunk)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0]


def test_the_odd_ones_are_counted_among_all(tmp_path: Path) -> None:
    """Two behind the camera, one off the image: each may be missing from any sample."""
    table = TABLE.copy()
    table[[3000, 5500], 2] *= -1
    table[4000, 3] = -700
    path = tmp_path / "points.csv"
    path.write_text(table_of(table.tolist()))
    tally, setup = Tally(), bc.Setup(width=1920, height=1080)
    for chunk in replace(many(path), setup=setup):
        tally.add(chunk)
    behind, off = tally.notes()
    assert behind.startswith(f"of all {N} points 2 lie behind the camera")
    assert f"points.csv:{3000 + 2}" in behind
    assert off.startswith(f"of all {N} points 1 lies off the image")
    assert f"points.csv:{4000 + 2}" in off


def test_items_are_made_when_asked_for() -> None:
    numbers = Lazily(5, str)
    assert list(numbers) == ["0", "1", "2", "3", "4"]
    assert numbers[-1] == "4"
    assert numbers[1:3] == ["1", "2"]
    with pytest.raises(IndexError):
        numbers[5]


def test_a_terabyte_without_lines_is_not_read_through(tmp_path: Path):
    path = tmp_path / "sparse.csv"
    for head in (b"", b"x,y,z,r,c\n1,2,3,4,5\n"):
        with path.open("wb") as stream:
            stream.write(head)
            stream.truncate(2**40)
        assert text.of_text(path, None) is None
