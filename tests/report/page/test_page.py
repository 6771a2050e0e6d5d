"""What the page says: the result document's numbers, other people's words as text."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import bayescal as bc
from bayescal.comparison.results import Comparison
from bayescal.points.heading import Heading
from bayescal.report.blocks import Section
from bayescal.report.document.comparison import comparison_document
from bayescal.report.page.page import Page, html, page_of, save_report
from bayescal.report.typography import symbol, typeset, visible
from tests.helpers.page import read
from tests.helpers.points_files import rows, text, write

HOSTILE = (
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "</script><b>",
    "\u202egnp.exe",
    "Ж汉😀",
    "x" * 500,
)


def test_size(thesis_page: Path):
    assert thesis_page.stat().st_size < 3_000_000


def test_numbers_are_the_result_documents(thesis_page: Path, thesis_defended: Comparison):
    found = read(thesis_page.read_text(encoding="utf-8"))
    embedded = json.loads(found.scripts["result"])
    expected = json.loads(json.dumps(comparison_document(thesis_defended, "bayescal report")))
    for made in (embedded, expected):
        made["provenance"].pop("created")
    assert embedded == expected
    shown = [float(a["data-value"]) for t, a in found.tags if t == "td" and "data-value" in a]
    for axis in embedded["axes"].values():
        for order in axis["orders"]:
            for name in ("rss_px2", "chi2", "log_evidence", "probability", "elpd_loo"):
                assert order[name] in shown
            for coefficient in order["coefficients"]:
                assert coefficient["mean"] in shown
                assert coefficient["sd"] in shown
        assert typeset(axis["verdict"]["text"]) in "".join(found.words)


def test_same_bytes_but_for_the_time():
    made = []
    for _ in range(2):
        axis = bc.compare(bc.thesis(), [1], axis="c", ess=400)
        made.append(html(page_of(axis, "bayescal report")))
    stamp = re.compile(r"\d{4}-\d\d-\d\d(T\d\d:\d\d:\d\d\+00:00| \d\d:\d\d UTC)")
    first, second = (stamp.sub("", page) for page in made)
    assert first == second
    assert len(stamp.findall(made[0])) > 1


@pytest.mark.parametrize("prior", ["field", "flat"])
def test_one_axis(prior: str):
    made = html(page_of(bc.compare(bc.thesis(), [1, 2], axis="r", prior=prior, ess=400), "x"))
    words = "".join(read(made).words)
    assert ("no order" in words) == (prior == "flat")
    assert "Both axes together" not in words


def test_arrays_of_x_and_y():
    x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    y = [0.1, 0.9, 2.2, 2.8, 4.1, 5.2]
    words = "".join(read(html(page_of(bc.compare_polynomials(x, y, [1, 2], ess=400), "x"))).words)
    assert "6 pairs of x and y" in words
    assert "image plane" not in words


def test_hostile_labels_are_text(tmp_path: Path):
    lines = [f"{row},{i}" for i, row in enumerate(text(rows(12)).splitlines()[1:])]
    head = text(rows(12)).splitlines()[0] + ",label"
    for i, label in enumerate(HOSTILE):
        quoted = label.replace('"', '""')
        lines[i] = lines[i].rsplit(",", 1)[0] + f',"{quoted}"'
    r, c = lines[0].split(",")[3:5]
    lines[0] = lines[0].replace(f",{r},{c},", f",{float(r) + 400},{float(c) + 400},", 1)
    path = write(tmp_path, "\n".join([head, *lines]) + "\n", name='<b>"points".csv')
    comparison = bc.compare(bc.load(path), [1], ess=400, defend=True)
    found = read(html(page_of(comparison, "bayescal report '<i>'")))
    bold = [a for t, a in found.tags if t == "b"]
    explained = [a for _, a in found.tags if "columns" in (a.get("class") or "")]
    assert len(bold) == len(explained)
    assert not any("onerror" in a for _, a in found.tags)
    assert sum(t == "script" for t, _ in found.tags) == 2
    words = "".join(found.words)
    assert "<script>alert(1)</script>" in words
    assert '<b>"points".csv' in words
    assert not re.search("[\u202a-\u202e\u2066-\u2069]", words)


def test_nothing_invisible_is_obeyed():
    assert visible("a\u202eb\u0000\ud800") == "a[U+202E]b[U+0000][U+D800]"
    assert visible("Ж汉😀é") == "Ж汉😀é"


def test_signs():
    assert typeset("-1.5, 3-4, run-2.csv, chi2, dAIC") == "−1.5, 3-4, run-2.csv, χ², ΔAIC"  # noqa: RUF001
    assert symbol("alpha_12") == "α₁₂"
    assert symbol("r: alpha_1, px") == "r: α₁, px"
    assert symbol("-5") == "−5"  # noqa: RUF001
    powers = typeset("1920 x 1080, 2e-06, 1.5e+20, 10^8, 3e8")
    assert powers == "1920 \xd7 1080, 2\xa0\xd7\xa010⁻⁶, 1.5\xa0\xd7\xa010²⁰, 10⁸, 3e8"
    said = typeset("tau * 1920, alpha_0 to alpha_12, d elpd +1.9±1.7, c = height - row; 95% of 4%")
    assert said.replace("\xa0", " ") == (
        "tau · 1920, α₀ to α₁₂, Δ elpd +1.9 ± 1.7, c = height − row; 95\u202f% of 4\u202f%"  # noqa: RUF001
    )
    assert (typeset("-"), typeset("a - b")) == ("–", "a - b")  # noqa: RUF001


def test_title_block_says_what_it_is_told_as_text():
    heading = Heading("<b>Plant 7</b>", "left", "A-1", "chi2 Ltd")
    section, created = Section("a", "A", "", ()), "2026-01-02T03:04:05+00:00"
    found = html(Page(heading.title, (), "", (section,), created, heading))
    assert "<h1>&lt;b&gt;Plant 7&lt;/b&gt;</h1>" in found
    pairs = re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", found)
    assert pairs[:4] == [
        ("Camera", "left"),
        ("Serial number", "A-1"),
        ("Operator", "chi2 Ltd"),
        ("Date", "2026-01-02 03:04 UTC"),
    ]
    assert len(re.findall("<dt>", html(Page("", (), "", (section,), created)))) == 2


def test_never_over_a_file_without_force(tmp_path: Path):
    comparison = bc.compare(bc.thesis(), [1], axis="c", ess=400)
    path = tmp_path / "report.html"
    save_report(comparison, path)
    with pytest.raises(bc.BayescalError, match="exists"):
        save_report(comparison, path)
    save_report(comparison, path, force=True)
