"""Tables in the forms that other programs write: read without an option, and what was assumed.

Truth: the same points in our own form.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import bayescal as bc
from bayescal.cli import main
from bayescal.points.notes import point_notes
from tests.helpers.points_files import rows, text, write

ROWS = rows()
TABLE = np.array(ROWS)
NAMES = [f"P{i}" for i in range(1, len(ROWS) + 1)]
FRAME = pd.DataFrame(TABLE, columns=list("xyzrc"))


def commas(table: np.ndarray) -> list[list[str]]:
    return [[repr(float(v)).replace(".", ",") for v in row] for row in table]


def spreadsheet() -> str:
    """As a spreadsheet of a country with decimal commas saves it, names first."""
    body = [[name, *row] for name, row in zip(NAMES, commas(TABLE), strict=True)]
    return text(body, "Punkt,X,Y,Z,u,v", separator=";", end="\r\n")


def savetxt() -> str:
    stream = io.StringIO()
    np.savetxt(stream, TABLE, fmt="%.17g", header="x y z r c")
    return stream.getvalue()


def quoted_commas() -> str:
    stream = io.StringIO()
    csv.writer(stream).writerows([list("xyzrc"), *commas(TABLE)])
    return stream.getvalue()


def r_table() -> str:
    """As write.table of R: quoted names, row names without a header of their own."""
    lines = [" ".join(f'"{name}"' for name in ["E", "N", "h", "px", "py"])]
    for i, row in enumerate(ROWS, 1):
        lines.append(" ".join([f'"{i}"', *map(repr, row)]))
    return "\n".join(lines) + "\n"


# The text, what the note must say (None: nothing), and the labels.
FORMS: dict[str, tuple[str, str | None, list[str] | None]] = {
    "pandas with index": (FRAME.to_csv(), "ignored 'a column without a name'", None),
    "pandas with named index": (
        FRAME.set_axis(NAMES).to_csv(index_label="id"),
        "id as label",
        NAMES,
    ),
    "spreadsheet with decimal commas": (
        spreadsheet(),
        "semicolons; decimal commas; u as r, v as c, Punkt as label",
        NAMES,
    ),
    "decimal commas in quotes": (quoted_commas(), "decimal commas", None),
    "decimal commas between blanks": (
        "\n".join(["x y z r c", *(" ".join(row) for row in commas(TABLE))]),
        "blanks; decimal commas",
        None,
    ),
    "numpy.savetxt": (savetxt(), "columns separated by blanks", None),
    "write.table of R": (r_table(), "E as x, N as y, h as z, px as r, py as c", None),
    "survey": (
        text(
            [
                [n, x, y, z, r, c, "2024-05-01"]
                for n, (x, y, z, r, c) in zip(NAMES, ROWS, strict=True)
            ],
            "Name,Easting [m],Northing [m],Height [m],col,row,date",
        ),
        "Height [m] as z, col as r, row as c, Name as label; ignored 'date'",
        NAMES,
    ),
    "row before column": (
        text([(x, y, z, c, r) for x, y, z, r, c in ROWS], "X,Y,Z,row,column"),
        "column as r, row as c",
        None,
    ),
    "aligned by blanks": (
        "\n".join("  ".join(f"{v!s:>24}" for v in row) for row in [list("XYZUV"), *ROWS]),
        "blanks; U as r, V as c",
        None,
    ),
    "extra columns": (
        text([(*row, 0.5, "ok") for row in ROWS], "x,y,z,r,c,weight,remark"),
        "ignored 'weight,remark'",
        None,
    ),
    "a comma too many": ("".join(line + ",\n" for line in text(ROWS).splitlines()), None, None),
    "names of errors": (
        text([(*row, 0.5) for row in ROWS], "x,y,z,u,v,sigma_u"),
        "as sigma_r",
        None,
    ),
}


@pytest.mark.parametrize("name", FORMS)
def test_the_same_points_are_read_and_the_note_says_how(name: str, tmp_path: Path) -> None:
    content, note, labels = FORMS[name]
    path = write(tmp_path, content)
    points = bc.load(path)
    np.testing.assert_array_equal(np.hstack([points.world, points.pixels]), TABLE)
    if labels is not None:
        assert list(points.labels) == labels
    if note is None:
        assert points.notes == ()
    else:
        (told,) = points.notes
        assert told.startswith(f"{path} was read with ")
        assert note in told
    assert list(points.notes) == point_notes(points)


def test_columns_are_stated_by_name_or_number(tmp_path: Path) -> None:
    odd = [(r, c, x, y, z) for x, y, z, r, c in ROWS]
    stated = {"names": ("A,B,C,D,E", "x=C,y=d,z=E,r=A,c=B"), "none": ("", "x=3,y=4,z=5,r=1,c=2")}
    for header, columns in stated.values():
        content = text(odd, header) if header else text(odd).split("\n", 1)[1]
        points = bc.load(write(tmp_path, content), columns=columns)
        np.testing.assert_array_equal(np.hstack([points.world, points.pixels]), TABLE)


@pytest.mark.parametrize(
    ("columns", "complaint"),
    [
        ("x", "columns: 'x' is no pair such as x=E"),
        ("q=E", "columns: 'q' is none of x, y, z, r, c"),
        ("x=y,x=z", "columns: x is stated twice"),
        ("x=W", ":1: no column 'W', stated for x; there are 'x,y,z,r,c'"),
        ("x=6", ":1: no column '6', stated for x"),
    ],
)
def test_stated_columns_that_are_not_there(columns: str, complaint: str, tmp_path: Path) -> None:
    with pytest.raises(bc.InputError, match=complaint):
        bc.load(write(tmp_path, text(ROWS)), columns=columns)


def test_numbers_without_names_are_never_guessed(tmp_path: Path) -> None:
    with pytest.raises(bc.InputError, match=r"say which is which: --columns x=1,y=2,z=3,r=4,c=5"):
        bc.load(write(tmp_path, text(ROWS).split("\n", 1)[1]))


def test_one_view_of_several(tmp_path: Path) -> None:
    views = [(f"v{i % 2}", *row) for i, row in enumerate(ROWS)]
    path = write(tmp_path, text(views, "view,x,y,z,r,c"))
    points = bc.load(path, view="v1")
    np.testing.assert_array_equal(points.pixels, TABLE[1::2, 3:])
    assert points.lines == tuple(range(3, len(ROWS) + 2, 2))
    with pytest.raises(bc.InputError, match="holds no view 'v2', but 'v0, v1'"):
        bc.load(path, view="v2")
    with pytest.raises(bc.InputError, match="2 views, 'v0, v1'; choose one with --view"):
        bc.load(path)


def test_a_run_keeps_what_was_assumed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path, spreadsheet(), "punkte.csv")
    command = ["compare", "punkte.csv", "--axis", "r", "--orders", "1", "--ess", "100"]
    main([*command, "--no-families", "--out", "run"])
    told = capsys.readouterr().out
    assert "punkte.csv was read with columns separated by semicolons" in " ".join(told.split())
    again = bc.open_run(tmp_path / "run")
    assert again.points.notes == bc.load("punkte.csv").notes
    assert again.points.labels == tuple(NAMES)


@pytest.mark.parametrize("read", [bc.load, bc.load_setup])
def test_no_more_is_read_than_stated(read: Callable[[Path], object], tmp_path: Path) -> None:
    """A device without end, and a file of a terabyte that holds nothing."""
    sparse = tmp_path / "sparse.csv"
    with sparse.open("wb") as stream:
        stream.truncate(10**12)
    for path in (Path("/dev/zero"), sparse):
        with pytest.raises(bc.InputError, match=r"holds more than (64|1) MB, the most that is"):
            read(path)
