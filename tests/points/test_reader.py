"""Points files: what is read, and what every complaint says."""

from __future__ import annotations

import hashlib
import io
import sys
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from tests.helpers.points_files import HEADER, rows, text, write

ROWS = rows()


def test_numbers_come_back_exactly(tmp_path: Path) -> None:
    path = write(tmp_path, text(ROWS))
    points = bc.load(path)
    np.testing.assert_array_equal(points.world, [row[:3] for row in ROWS])
    np.testing.assert_array_equal(points.pixels, [row[3:] for row in ROWS])
    assert points.labels == tuple(str(i + 1) for i in range(len(ROWS)))
    assert points.lines == tuple(range(2, len(ROWS) + 2))
    assert points.place(3) == f"{path}:5"
    assert points.source == str(path)
    assert points.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert points.setup == bc.Setup()


@pytest.mark.parametrize(
    "content",
    [
        text(ROWS, separator="\t"),
        text(ROWS, end="\r\n"),
        text(ROWS, end="\r"),
        text(ROWS).rstrip("\n"),
        "\ufeff" + text(ROWS),
        text(ROWS, "X, Y ,Z,R,C"),
        text([(c, r, z, y, x) for x, y, z, r, c in ROWS], "c,r,z,y,x"),
        text([[f" {value} " for value in row] for row in ROWS]),
        text([[f'"{value}"' for value in row] for row in ROWS], '"x","y","z","r","c"'),
        "# made by hand\n\n   # indented\n" + text(ROWS).replace("\n", "\n# between\n\n"),
        text(ROWS) + ",,,,\n\n  \n",
        text([[f"{value:.17e}" for value in row] for row in ROWS]),
    ],
    ids=[
        "tabs",
        "crlf",
        "cr",
        "no last newline",
        "byte-order mark",
        "header in capitals",
        "any order of columns",
        "blanks",
        "quotes",
        "comments and blank lines",
        "empty rows",
        "exponents",
    ],
)
def test_written_in_other_ways_they_are_the_same_points(content: str, tmp_path: Path) -> None:
    points = bc.load(write(tmp_path, content))
    np.testing.assert_array_equal(np.hstack([points.world, points.pixels]), ROWS)


def test_optional_columns(tmp_path: Path) -> None:
    table = [(f"p {i}", *row, "wall, left", 0.5 + i, 2.0) for i, row in enumerate(ROWS)]
    table = [(*row[:6], '"wall, left"', *row[7:]) for row in table]
    points = bc.load(write(tmp_path, text(table, "label,x,y,z,r,c,group,sigma_r,sigma_c")))
    assert points.labels[:2] == ("p 0", "p 1")
    assert points.groups == ("wall, left",) * len(ROWS)
    np.testing.assert_array_equal(points.sigma["r"], 0.5 + np.arange(len(ROWS)))
    np.testing.assert_array_equal(points.sigma["c"], 2.0)
    only_c = bc.load(write(tmp_path, text([(*row, 3) for row in ROWS], f"{HEADER},sigma_c")))
    assert set(only_c.sigma) == {"c"}


def test_label_that_is_missing_becomes_the_number(tmp_path: Path) -> None:
    points = bc.load(write(tmp_path, "label,x,y,z,r,c\na,1,2,3,4,5\n,1,2,3,4,5\n"))
    assert points.labels == ("a", "2")


def test_label_over_several_lines_is_folded_and_lines_still_counted(tmp_path: Path) -> None:
    points = bc.load(write(tmp_path, 'label,x,y,z,r,c\n"a\n b\t""c""",1,2,3,4,5\nd,1,2,3,4,5\n'))
    assert points.labels == ('a b "c"', "d")
    assert points.lines == (2, 4)


def test_lines_are_the_files_own(tmp_path: Path) -> None:
    points = bc.load(write(tmp_path, f"# one\n\n{HEADER}\n1,2,3,4,5\n# five\n\n1,2,3,4,5\n"))
    assert points.lines == (4, 7)


def test_standard_input(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text(ROWS).encode())))
    points = bc.load("-")
    assert len(points) == len(ROWS)
    assert points.place(0) == "standard input:2"


# What stands in the file, and what the complaint must say.
BAD = {
    "missing column": ("x,y,z,r\n1,2,3,4\n", ":1: no column 'c'"),
    "two missing columns": ("x,z,r\n1,2,3\n", ":1: no column 'y', 'c'"),
    "no header": ("1,2,3,4,5\n6,7,8,9,10\n", ":1: no column"),
    "doubled column": ("x,y,z,r,c,R\n1,2,3,4,5,6\n", ":1: column 'r' stands twice"),
    "long column": (f"{'w' * 9999},y,z,r,c\n", r":1: no column 'x' among 'w{40}'\.\.\.; name"),
    "word": (f"{HEADER}\n1,2,3,4,5\n1,2,three,4,5\n", ":3: z: 'three' where a number should be"),
    "empty field": (f"{HEADER}\n1,2,,4,5\n", ":2: z: '' where a number should be"),
    "both decimal marks": (f'{HEADER}\n1.5,2,3,4,5\n"1,5",2,3,4,5\n', ":3: x: '1,5' where a"),
    "digit groups and decimals": (f"{HEADER}\n".replace(",", ";") + "1.000,5;2;3;4;5\n", ":2: x: "),
    "digit groups": (f"{HEADER}\n1_000,2,3,4,5\n", ":2: x: '1_000' where a number should be"),
    "superscript": (f"{HEADER}\n²,2,3,4,5\n", ":2: x: '²' where a number should be"),
    "hexadecimal": (f"{HEADER}\n0x10,2,3,4,5\n", ":2: x: '0x10' where a number should be"),
    "long word": (f"{HEADER}\n{'w' * 9999},2,3,4,5\n", r":2: x: 'w{40}'\.\.\. where"),
    "nan": (f"{HEADER}\n1,2,3,4,NaN\n", ":2: c: is nan"),
    "infinity": (f"{HEADER}\n1,-Infinity,3,4,5\n", ":2: y: is -inf"),
    "beyond doubles": (f"{HEADER}\n1e999,2,3,4,5\n", ":2: x: is inf"),
    "400 digits": (f"{HEADER}\n{'9' * 400},2,3,4,5\n", ":2: x: is inf"),
    "huge coordinate": (f"{HEADER}\n1e100,2,3,4,5\n", r":2: x: is 1e\+100, too large"),
    "huge pixel": (f"{HEADER}\n1,2,3,-1e9,5\n", r":2: r: is -1e\+09; no pixel is that far out"),
    "sigma 0": (f"{HEADER},sigma_r\n1,2,3,4,5,0\n", ":2: sigma_r: is 0; .* must be positive"),
    "sigma -1": (f"{HEADER},sigma_c\n1,2,3,4,5,-1\n", ":2: sigma_c: is -1; .* must be positive"),
    "sigma 1e-300": (f"{HEADER},sigma_c\n1,2,3,4,5,1e-300\n", ":2: sigma_c: is 1e-300; .* from"),
    "sigma nan": (f"{HEADER},sigma_c\n1,2,3,4,5,nan\n", ":2: sigma_c: is nan"),
    "empty": ("", ": is empty"),
    "comments only": ("# nothing\n\n  \n", ": is empty"),
    "header only": (f"{HEADER}\n# nothing\n", ": there are no points below the header"),
    "short row": (f"{HEADER}\n1,2,3,4,5\n1,2,3\n", ":3: has 3 fields where the header has 5"),
    "long row": (f"{HEADER}\n1,2,3,4,5,6\n", ":2: has 6 fields where the header has 5"),
    "lines above": (
        f"Date: 2026\nBy: me\n{HEADER}\n1,2,3,4,5\n",
        r":3: has 1 field where the first line has 2 \('Date:,2026', line 1\)",
    ),
    "json": ('[{"x": 1, "y": 2}]', ":1: looks like JSON; give a table with columns x,y,z,r,c"),
    "html": ("<html><body>moved</body></html>\n", ":1: looks like HTML or XML; give a table"),
    "thousands": (
        f'{HEADER}\n"1,500",2,3,4,5\n"2,500",2,3,4,5\n',
        ":2: '1,500' may be 1.500 or 1500; write it without a comma",
    ),
    "zip": (b"PK\x03\x04\0\0", ": is a zip archive, perhaps a workbook .* cut off; save it anew"),
    "unclosed quote": (f"label,{HEADER}\na,1,2,3,4,5\n" + '"b,1,2,3,4,5\nc,1,2,3,4,5\n', ":3: "),
    "text after quote": (f'{HEADER}\n"1"a,2,3,4,5\n', ":2: "),
    "line of 10 MB": (f"{HEADER}\n{'1' * 10_000_000}\n", ":2: field larger than field limit"),
    "two sets of pixels": ("x,y,z,u,v,px\n1,2,3,4,5,6\n", ":1: columns 'u' and 'px' could both be"),
    "world and image x": (
        "x,y,z,X,Y\n1,2,3,4,5\n",
        ":1: column 'x' stands twice; keep one, or say",
    ),
    "several views": ("view,x,y,z,r,c\na,1,2,3,4,5\nb,1,2,3,4,5\n", "2 views, 'a, b'; choose one"),
    "100000 columns": (",".join(f"q{i}" for i in range(100_000)), ":1: no column"),
    "binary": (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", ":3: holds a null byte"),
    "null byte": (f"{HEADER}\n1,2,3,4,5\n1,2\0,3,4,5\n", ":3: holds a null byte"),
    "utf-16": (text(ROWS).encode("utf-16"), ":1: is UTF-16 text; save the file as UTF-8"),
    "latin-1": (f"# \nlabel,{HEADER}\né,1,2,3,4,5\n".encode("latin-1"), ":3: is not UTF-8"),
}


@pytest.mark.parametrize("name", BAD)
def test_complaint_is_one_line_with_the_place(name: str, tmp_path: Path) -> None:
    content, complaint = BAD[name]
    path = write(tmp_path, content)
    with pytest.raises(bc.InputError, match=complaint) as caught:
        bc.load(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:")
    assert len(message.splitlines()) == 1
    assert len(message.removeprefix(str(path))) < 200


def test_complaint_about_a_file_that_can_not_be_read(tmp_path: Path) -> None:
    loop = tmp_path / "loop.csv"
    loop.symlink_to(loop)
    inside_a_file = write(tmp_path, text(ROWS)) / "points.csv"
    for path, complaint in [
        (tmp_path, "is a directory"),
        (tmp_path / "none.csv", "there is no such file"),
        (loop, "symbolic links"),
        (inside_a_file, "not a directory"),
        (tmp_path / ("n" * 300), "file name too long"),
        (tmp_path / "a\0b", "null"),
    ]:
        with pytest.raises(bc.InputError, match=complaint):
            bc.load(path)


def test_label_that_could_be_a_formula_or_markup_is_only_a_label(tmp_path: Path) -> None:
    names = ["=1+1", "@SUM(A1)", "[bold red]x[/]", "-2+3", "+1", "x" * 10_000, "\u202eevil", "🎯"]
    table = [(*row, name) for row, name in zip(ROWS, names, strict=False)]
    points = bc.load(write(tmp_path, text(table, f"{HEADER},label")))
    assert points.labels == tuple(names)
