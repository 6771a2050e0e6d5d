"""Numbers of tables and figures, and what is said once."""

from __future__ import annotations

import re
from pathlib import Path

from bayescal.report.blocks import Details, Part, Picture, Section, Tabled
from bayescal.report.page.numbering import numbered
from bayescal.report.table import Cell, Column, Table

ORDER = Column("order", "degree")
SE = Column("SE", "standard error")


def made(id: str, *columns: Column, notes: tuple[str, ...] = ()) -> Tabled:
    return Tabled(id, "", Table(columns, (tuple(Cell("1") for _ in columns),)), notes)


def picture(id: str) -> Picture:
    return Picture(id, "data:,", "", "", 1, 1)


def test_numbers_run_through_chapters_parts_and_folds_in_reading_order():
    first = Section("a", "", "", (picture("p"), Part("", (made("t", ORDER),))))
    second = Section("b", "", "", (Details("", (made("u", ORDER), picture("q"))), picture("s")))
    a, b = numbered((first, second))
    found = [a.blocks[0], a.blocks[1].blocks[0], *b.blocks[0].blocks, b.blocks[1]]
    assert [(one.id, one.label) for one in found] == [
        ("p", "Figure 1"),
        ("t", "Table 1"),
        ("u", "Table 2"),
        ("q", "Figure 2"),
        ("s", "Figure 3"),
    ]


def test_a_column_is_explained_once_and_the_others_say_where():
    tables = (
        made("one", ORDER, notes=("same",)),
        made("two", ORDER, SE, notes=("own", "same")),
        made("three", Column("order", "another meaning"), SE),
        made("four", ORDER, SE),
    )
    (section,) = numbered((Section("a", "", "", tables),))
    one, two, three, four = section.blocks
    assert (one.columns, one.notes, one.elsewhere) == ((("order", "degree"),), ("same",), ())
    assert two.columns == (("SE", "standard error"),)
    assert (two.notes, two.elsewhere) == (("own",), (("one", "Table 1"),))
    assert three.columns == (("order", "another meaning"),)
    assert three.elsewhere == (("two", "Table 2"),)
    assert (four.columns, four.elsewhere) == ((), (("one", "Table 1"), ("two", "Table 2")))


def test_every_number_on_the_page_is_of_what_it_leads_to(thesis_page: Path):
    text = thesis_page.read_text(encoding="utf-8")
    cited = re.findall(r'<a class="label" href="#([^"]+)">(Table|Figure) (\d+)</a>', text)
    for noun in ("Table", "Figure"):
        numbers = [int(n) for _, kind, n in cited if kind == noun]
        assert numbers == list(range(1, len(numbers) + 1))
    assert len({id for id, *_ in cited}) == len(cited) > 50
    assert {id for id, *_ in cited} <= set(re.findall(r' id="([^"]+)"', text))
