"""The page in a real browser: what it loads, how it sorts, who can read it."""

from __future__ import annotations

import io
import itertools
from contextlib import contextmanager
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from PIL import Image
from playwright.sync_api import Browser, Page

from bayescal.report.blocks import Section, Tabled
from bayescal.report.page.page import Page as PageOf
from bayescal.report.page.page import html
from bayescal.report.table import Cell, Column, Table


@contextmanager
def opened(browser: Browser, path: Path, width: int = 1024, scheme: str = "light", **more: bool):
    context = browser.new_context(
        viewport={"width": width, "height": 900}, color_scheme=scheme, **more
    )
    page = context.new_page()
    page.goto(path.as_uri())
    yield page
    context.close()


def test_nothing_is_requested_and_nothing_complained_of(browser: Browser, thesis_page: Path):
    context = browser.new_context()
    page = context.new_page()
    asked: list[str] = []
    said: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(thesis_page.as_uri())
    assert [url for url in asked if not url.startswith("data:")] == [thesis_page.as_uri()]
    assert said == []
    loaded = "() => [...document.images].map(i => i.complete && i.naturalWidth > 0)"
    images = page.evaluate(loaded)
    assert len(images) > 25
    assert all(images)
    assert all(page.evaluate("() => [...document.images].map(i => i.alt.length > 20)"))
    context.close()


@pytest.mark.parametrize("scripts", [True, False])
@pytest.mark.parametrize("width", [390, 1024, 1920])
def test_nothing_overflows(browser: Browser, thesis_page: Path, width: int, scripts: bool):
    with opened(browser, thesis_page, width, java_script_enabled=scripts) as page:
        seen = page.locator("html").bounding_box()
        widest = "() => document.documentElement.scrollWidth"
        if scripts:
            assert page.evaluate(widest) <= width
        assert seen is not None
        assert seen["width"] <= width
        assert page.locator("h2").count() == 14
        assert page.locator("th button").count() == (page.locator("thead th").count() * scripts)


def test_contents_mark_what_is_read(browser: Browser, thesis_page: Path):
    with opened(browser, thesis_page) as page:
        marked = page.locator("nav a[aria-current]")
        assert marked.all_inner_texts() == ["1 Verdict"]
        for section in ("adequacy", "provenance"):
            page.evaluate("id => document.getElementById(id).scrollIntoView()", section)
            page.wait_for_function(
                "id => document.querySelector('nav a[aria-current]').hash === '#' + id", arg=section
            )
            assert marked.count() == 1


def test_what_is_cut_off_says_so(browser: Browser, thesis_page: Path):
    with opened(browser, thesis_page, 390) as page:
        wide = page.locator("#orders-r .scroll")
        assert "more-right" in wide.get_attribute("class")
        assert wide.get_attribute("tabindex") == "0"
        cue = "e => getComputedStyle(e, '::after').content"
        assert "scroll" in page.locator("#orders-r .caption").evaluate(cue)
        wide.evaluate("e => { e.scrollLeft = e.scrollWidth; }")
        page.wait_for_function(
            "() => !document.querySelector('#orders-r .scroll').matches('.more-right')"
        )
    with opened(browser, thesis_page, 1920) as page:
        assert page.locator(".scroll.more-right").count() == 0


def test_figures_have_the_papers_colour_in_the_dark(browser: Browser, thesis_page: Path):
    """The figures' white, inverted, is the page's background: there is no frame to be seen."""
    with opened(browser, thesis_page, scheme="dark") as page:
        figure = page.locator("#figure-verdict img")
        box = figure.bounding_box()
        around = {"x": box["x"] - 6, "y": box["y"] + 2, "width": 12, "height": 12}
        shot = page.screenshot(clip=around)
    with Image.open(io.BytesIO(shot)) as image:
        assert image.convert("RGB").getcolors() == [(144, (23, 23, 23))]


def test_paper_shows_what_the_screen_folds_away(browser: Browser, thesis_page: Path):
    with opened(browser, thesis_page) as page:
        hidden = page.locator("#covariance-r-4")
        assert not hidden.is_visible()
        page.emulate_media(media="print")
        assert hidden.is_visible()


def test_paper_sets_what_is_folded_away_side_by_side(browser: Browser, thesis_page: Path):
    """Curves of orders that are not excluded two a line, a covariance beside its coefficients."""
    with opened(browser, thesis_page, 642) as page:  # 170 mm
        page.emulate_media(media="print")

        def box(place: str) -> dict[str, float]:
            found = page.locator(place).bounding_box()
            assert found is not None, place
            return dict(found)

        for left, right in (
            ("#figure-curve-c-2 img", "#figure-curve-c-4 img"),
            ("#coefficients-r-1", "#covariance-r-1"),
        ):
            one, other = box(left), box(right)
            assert one["y"] == other["y"]
            assert one["x"] + one["width"] <= other["x"]
            assert other["x"] + other["width"] <= 642


def test_paper_cuts_no_table_off(browser: Browser, tmp_path: Path):
    """A covariance of 22 parameters, on A4 between the margins."""
    heads = tuple(Column(f"alpha_{i}") for i in range(23))
    rows = ((Cell("alpha_1"), *[Cell("-0.00123")] * 22),) * 3
    wide = Tabled("wide", "Covariance.", Table(heads, rows))
    sections = (Section("a", "A", "", (wide,)),)
    path = tmp_path / "wide.html"
    made = html(PageOf("", (), "", sections, "2026-01-02T03:04:05+00:00"))
    path.write_text(made, encoding="utf-8")
    with opened(browser, path, 642) as page:  # 170 mm
        page.emulate_media(media="print")
        box = page.locator("#wide table").bounding_box()
        assert box is not None
        assert box["x"] + box["width"] <= 642


def column(page: Page, number: int) -> list[float]:
    cells = page.locator(f"#orders-r tbody tr > :nth-child({number})")
    return [float(v) for v in cells.evaluate_all("all => all.map(c => c.dataset.value)")]


def test_tables_are_sorted_by_keyboard(browser: Browser, thesis_page: Path):
    with opened(browser, thesis_page) as page:
        head = page.locator("#orders-r thead th").last
        before = column(page, 13)
        head.locator("button").focus()
        page.keyboard.press("Enter")
        assert column(page, 13) == sorted(before) != before
        assert head.get_attribute("aria-sort") == "ascending"
        page.keyboard.press("Space")
        assert column(page, 13) == sorted(before, reverse=True)
        assert head.get_attribute("aria-sort") == "descending"
        page.locator("#orders-r thead th button").first.press("Enter")
        assert column(page, 1) == [1, 2, 3, 4, 5]
        assert head.get_attribute("aria-sort") is None


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(browser: Browser, thesis_page: Path, scheme: str):
    with opened(browser, thesis_page, scheme=scheme) as page:
        page.evaluate("() => document.querySelectorAll('details').forEach(d => d.open = true)")
        found = Axe().run(page).response["violations"]
    serious = [v for v in found if v["impact"] in ("serious", "critical")]
    assert [(v["id"], v["nodes"][0]["html"][:200]) for v in serious] == []


def test_headings_are_in_order(browser: Browser, thesis_page: Path):
    with opened(browser, thesis_page) as page:
        read = "all => all.map(h => Number(h.tagName[1]))"
        levels = page.locator("h1, h2, h3, h4").evaluate_all(read)
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in itertools.pairwise(levels))
