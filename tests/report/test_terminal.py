"""What the terminal is sent: text of its width, and no command but the program's own."""

from __future__ import annotations

import pytest

from bayescal.report.blocks import Facts, Listing, Part, Tabled
from bayescal.report.table import Cell, Column, Table
from bayescal.report.terminal import printed, render

HOSTILE = "\x1b[31mred\x07 \u202elive\u202c \x9b2J \u2066x"


@pytest.mark.parametrize("terminal", [False, True])
def test_labels_command_no_terminal(terminal, monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    plain = render((Part("plain", ()),), terminal=terminal)
    assert plain == ("\x1b[1mplain\x1b[0m\n" if terminal else "plain\n")
    lines = HOSTILE, "\U0001f3f3\ufe0f\u200d\U0001f308 é"
    shown = render((Listing(lines, "about"),), terminal=terminal)
    assert shown == "?[31mred ?live? ?2J ?x\n\U0001f3f3\ufe0f\u200d\U0001f308 é\n"


@pytest.mark.parametrize("label", ["[/]", "[red]x[/red]", ":smile:", "[link=http://a]b[/link]"])
def test_a_label_in_a_table_is_shown_as_it_is(label):
    table = Table((Column("point"), Column("x")), ((Cell(label), Cell("1")),))
    shown = render((Tabled("points", "", table),), terminal=False)
    assert shown.splitlines()[-1].split() == [label, "1"]
    shown = render((Facts((("name", label),)),), terminal=False)
    assert shown.split() == ["name:", label]


@pytest.mark.parametrize("width", [60, 80, 100])
def test_nothing_is_wider_than_the_terminal_and_nothing_lost(width):
    """Eight columns of 14 letters and numbers: what doesn't fit goes on below."""
    heads = [f"{'abcdefgh'[i] * 12}{i}" for i in range(8)]
    rows = tuple(tuple(Cell(f"{row}{column}{'0' * 10}") for column in range(8)) for row in range(3))
    table = Tabled("t", "", Table(tuple(map(Column, heads)), rows), ("a note " * 30,))
    shown = render((table, Facts((("name", "a value " * 30),))), terminal=False, width=width)
    assert max(map(len, shown.splitlines())) <= width
    words = shown.split()
    assert all(words.count(cell.text) == 1 for row in rows for cell in row[1:])
    assert all(words.count(head) == 1 for head in heads[1:])
    firsts = words.count(heads[0])
    assert firsts == -(-7 // ((width + 1) // 15 - 1))
    assert all(words.count(row[0].text) == firsts for row in rows)


@pytest.mark.parametrize(("columns", "width"), [(40, 60), (72, 72), (250, 100)])
def test_a_terminal_s_own_width_is_used_within_bounds(columns, width, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    view = (Facts((("name", "a word " * 60),)),)
    assert printed(view) == render(view, terminal=True, width=width)
    monkeypatch.setattr("sys.stdout.isatty", lambda: False, raising=False)
    assert printed(view) == render(view, terminal=False, width=100)


def test_columns_that_go_on_below_stand_beside_what_names_their_rows():
    """Two models of one family: what is below is told apart by the order."""
    heads = Column("family"), Column("order"), *(Column(f"quantity {i}") for i in range(6))
    rows = tuple((Cell("pinhole"), Cell(k), *[Cell(f"{k}.00000")] * 6) for k in "12")
    table = Table(heads, rows, marked=0, by_order=True, naming=2)
    shown = render((Tabled("t", "", table),), terminal=False, width=60).splitlines()
    for order, mark in (("1", ["> pinhole"]), ("2", ["pinhole"])):
        lines = [line.split() for line in shown if f"{order}.00000" in line]
        assert len(lines) == 2
        assert all(line[: len(mark[0].split()) + 1] == [*mark[0].split(), order] for line in lines)
    assert max(map(len, shown)) <= 60
