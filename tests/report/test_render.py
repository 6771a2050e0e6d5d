"""What the terminal is sent: 100 columns of text, and no command but the program's own."""

from __future__ import annotations

import pytest
from rich.console import Group
from rich.text import Text

from bayescal.report.blocks import Facts, Tabled
from bayescal.report.table import Cell, Column, Table
from bayescal.report.terminal import render

HOSTILE = "\x1b[31mred\x07 \u202elive\u202c \x9b2J \u2066x"


@pytest.mark.parametrize("terminal", [False, True])
def test_labels_command_no_terminal(terminal, monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    plain = render(Text("plain", style="bold"), terminal=terminal)
    assert plain == ("\x1b[1mplain\x1b[0m\n" if terminal else "plain\n")
    shown = render(
        Group(Text(HOSTILE), Text("\U0001f3f3\ufe0f\u200d\U0001f308 é")), terminal=terminal
    )
    assert shown == "?[31mred ?live? ?2J ?x\n\U0001f3f3\ufe0f\u200d\U0001f308 é\n"


@pytest.mark.parametrize("label", ["[/]", "[red]x[/red]", ":smile:", "[link=http://a]b[/link]"])
def test_a_label_in_a_table_is_shown_as_it_is(label):
    table = Table((Column("point"), Column("x")), ((Cell(label), Cell("1")),))
    shown = render((Tabled("points", "", table),), terminal=False)
    assert shown.splitlines()[-1].split() == [label, "1"]
    shown = render((Facts((("name", label),)),), terminal=False)
    assert shown.split() == ["name:", label]
