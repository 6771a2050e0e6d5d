"""What results show in a notebook: right numbers, escaped labels, sound and self-contained HTML."""

from __future__ import annotations

from html.parser import HTMLParser

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.results import Comparison
from bayescal.markup import bullets, paragraph, table
from bayescal.rounding import percent

NASTY = "<script>alert('1')</script> & \"quoted\""


class Page(HTMLParser):
    """Collects tags, attributes, the rows of tables and all text; refuses wrong nesting."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.rows: list[list[str]] = []
        self.text = ""
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.open.append(tag)
        self.tags.append((tag, dict(attrs)))
        if tag == "tr":
            self.rows.append([])
        elif tag in ("th", "td"):
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data
        if self.open and self.open[-1] in ("th", "td"):
            self.rows[-1][-1] += data


def test_labels_are_text_wherever_they_stand():
    html = table(NASTY, [NASTY], [[NASTY], ["b"]]) + bullets(NASTY, [NASTY]) + paragraph(NASTY)
    page = Page(html)
    assert page.text.count(NASTY) == 6
    assert "script" not in {tag for tag, _ in page.tags}


def test_a_list_of_nothing_is_nothing():
    assert bullets("Caveats", []) == ""


def test_a_comparison_shows_its_orders_and_its_verdict(thesis_comparison: Comparison):
    page = Page(thesis_comparison._repr_html_())
    rows = [row for row in page.rows if row[0][0].isdigit()]
    results = [r for axis in thesis_comparison.axes.values() for r in axis.orders]
    assert len(rows) == len(results) == 10
    for row, result in zip(rows, results, strict=True):
        assert row[0].split()[0] == str(result.order)
        assert float(row[1]) == pytest.approx(result.rss_px2, abs=0.05)
        assert float(row[5]) == pytest.approx(result.log_evidence, abs=0.005)
        assert row[6] == percent(result.probability)
    assert [row[0] for row in rows if "recommended" in row[0]] == [
        "4 (recommended)",
        "1 (recommended)",
    ]
    for axis in thesis_comparison.axes.values():
        assert axis.verdict.text in page.text
    for note in thesis_comparison.notes:
        assert note in page.text


def test_a_posterior_shows_its_parameters(thesis_comparison: Comparison):
    posterior = thesis_comparison.axes["r"].chosen.posterior
    page = Page(posterior._repr_html_())
    heads, *rows = page.rows
    assert heads[:4] == ["parameter", "mean", "sd", "95% interval"]
    assert tuple(row[0] for row in rows) == posterior.names
    for row, p in zip(rows, posterior.parameters, strict=True):
        assert abs(float(row[1]) - p.mean) < p.sd / 10  # two digits of the sd
        assert float(row[2]) == pytest.approx(p.sd, rel=0.05)
        low, high = map(float, row[3].split(" to "))
        assert low < p.mean < high


def test_what_can_not_be_had_is_blank_and_labels_in_caveats_are_escaped():
    x = np.arange(9.0)
    flat = bc.compare_polynomials(x, x**2 % 7, [1, 2], prior="flat", ess=100)
    page = Page(flat._repr_html_())
    assert [row[5:] for row in page.rows[1:]] == [["", ""], ["", ""]]
    assert "recommended)" not in page.text
    assert "None" not in page.text


def test_tables_are_accessible_and_ask_for_nothing(thesis_comparison: Comparison):
    page = Page(thesis_comparison._repr_html_())
    tags = [tag for tag, _ in page.tags]
    assert tags.count("caption") == tags.count("table") == 2
    assert all(found.get("scope") in ("row", "col") for tag, found in page.tags if tag == "th")
    assert not {"script", "img", "link", "style", "iframe"} & set(tags)
    for _, found in page.tags:
        assert set(found) <= {"style", "scope"}
        assert "color" not in (found.get("style") or "")  # the notebook's theme holds
