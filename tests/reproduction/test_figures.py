"""What the figures hold: labels with units, limits, artists, the points they name."""

from __future__ import annotations

import re
from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.text import Annotation, Text

import bayescal as bc
from bayescal.report.figures.style import save_figure
from bayescal.reproduction.error_figures import NAMED, ErrorKind, error_figure
from bayescal.reproduction.figures import thesis_figures

OKABE_ITO = {"#0072b2", "#d55e00"}
ERRORS = {
    "figure-07-residuals-r": ("r", False, False, "residual of r, measured - predicted [px]"),
    "figure-08-residuals-c": ("c", False, False, "residual of c, measured - predicted [px]"),
    "figure-09-squared-errors-r": ("r", True, False, "squared error of r [px²]"),
    "figure-10-squared-errors-c": ("c", True, False, "squared error of c [px²]"),
    "figure-07-residuals-r-standardised": (
        "r",
        False,
        True,
        "standardised residual of r [$\\sigma$]",
    ),
    "figure-08-residuals-c-standardised": (
        "c",
        False,
        True,
        "standardised residual of c [$\\sigma$]",
    ),
    "figure-09-squared-errors-r-standardised": (
        "r",
        True,
        True,
        "squared standardised residual of r [$\\sigma^2$]",
    ),
    "figure-10-squared-errors-c-standardised": (
        "c",
        True,
        True,
        "squared standardised residual of c [$\\sigma^2$]",
    ),
}


@pytest.fixture(scope="module")
def reproduction():
    return bc.reproduce(bc.thesis())


@pytest.fixture(scope="module")
def figures(reproduction):
    return thesis_figures(reproduction)


def panels(figure, reproduction, axis):
    """Pairs of a panel and the order it shows: rows are orders, columns variants."""
    models = [m for m in reproduction.models if m.axis == axis]
    shown = [(model, order) for row in zip(*(m.orders for m in models), strict=True)
             for model, order in zip(models, row, strict=True)]  # fmt: skip
    assert len(figure.axes) == len(shown)
    return [(ax, model, order) for ax, (model, order) in zip(figure.axes, shown, strict=True)]


def heights(order, squared, standardised):
    """What a panel should draw, from residuals and leverages alone."""
    e, h = order.before.residuals, order.before.fit.leverages
    if standardised:
        own = e**2 / (1 - h)
        dof = order.before.fit.dof - 1
        e = np.sign(e) * np.sqrt(own / ((order.before.rss - own) / dof))
    return e**2 if squared else e


def markers(ax):
    """Points drawn as markers: colour to (numbers, heights)."""
    lines = [line for line in ax.lines if line.get_marker() in ("o", "D")]
    return {to_hex(line.get_color()): line.get_xydata().T for line in lines}


def names(ax):
    return sorted(int(t.get_text()) for t in ax.texts if isinstance(t, Annotation))


def test_the_figures_are_six_to_ten_and_seven_to_ten_standardised(figures):
    assert list(figures) == ["figure-06-pixels", *ERRORS]


@pytest.mark.parametrize("name", ERRORS)
def test_axes_are_labelled_with_units_and_shared(figures, reproduction, name):
    axis, _, _, label = ERRORS[name]
    figure = figures[name]
    assert figure.get_supylabel() == label
    columns = 2 if axis == "r" else 1
    bottom = figure.axes[-columns:]
    assert [ax.get_xlabel() for ax in bottom] == ["point number"] * columns
    assert (
        len({ax.get_xlim() for ax in figure.axes})
        == len({ax.get_ylim() for ax in figure.axes})
        == 1
    )
    for ax, model, order in panels(figure, reproduction, axis):
        assert re.fullmatch(
            rf"{model.name}( = as written)?, order {order.order}: RSS {order.before.rss:.1f} px²",
            ax.get_title(loc="left"),
        )


@pytest.mark.parametrize("name", ERRORS)
def test_every_point_is_drawn_once_within_the_limits(figures, reproduction, name):
    axis, squared, standardised, _ = ERRORS[name]
    for ax, _, order in panels(figures[name], reproduction, axis):
        drawn = markers(ax)
        assert set(drawn) <= OKABE_ITO
        numbers, values = np.concatenate(list(drawn.values()), axis=1)
        assert sorted(numbers) == list(range(1, 58))
        truth = heights(order, squared, standardised)
        assert values[np.argsort(numbers)] == pytest.approx(truth, rel=1e-8, abs=1e-9)
        low, high = ax.get_ylim()
        assert low <= values.min()
        assert high > values.max()
        assert ax.get_xlim() == (0, 58)
        stems = sum(len(lines.get_segments()) for lines in ax.collections)
        assert stems == 57


@pytest.mark.parametrize("name", ERRORS)
def test_points_that_the_elimination_removes_are_marked(figures, reproduction, name):
    for ax, _, order in panels(figures[name], reproduction, ERRORS[name][0]):
        removed = {point + 1 for point in order.rejection.removed}
        assert set(markers(ax)["#d55e00"][0]) == removed
        assert set(markers(ax)["#0072b2"][0]) == set(range(1, 58)) - removed


@pytest.mark.parametrize("name", ERRORS)
def test_points_are_named_by_the_stated_rule(figures, reproduction, name):
    for ax, _, order in panels(figures[name], reproduction, ERRORS[name][0]):
        wanted = {int(i) for i in np.flatnonzero(order.tests.p_values < 0.05)}
        wanted |= set(order.rejection.removed)
        size = np.abs(order.tests.standardised)
        largest = sorted(wanted, key=lambda i: -size[i])[:NAMED]
        assert names(ax) == sorted(i + 1 for i in largest)


def test_the_known_suspects_are_named(figures, reproduction):
    """16, 19 and 1 on c; 44, 6 and 4 on r as written at order 4."""
    on_c = panels(figures["figure-10-squared-errors-c"], reproduction, "c")
    assert names(on_c[0][0]) == [1, 16, 19]
    on_r = panels(figures["figure-09-squared-errors-r"], reproduction, "r")
    assert next(names(ax) for ax, m, o in on_r if (m.variant, o.order) == ("as-written", 4)) == [
        4,
        6,
        44,
    ]


@pytest.mark.parametrize("name", ERRORS)
def test_thresholds_are_drawn_where_chi_squared_means_something(figures, reproduction, name):
    axis, squared, standardised, _ = ERRORS[name]
    for ax, _, order in panels(figures[name], reproduction, axis):
        dashed = {line.get_ydata()[0] for line in ax.lines if line.get_linestyle() in ("--", ":")}
        truth = set()
        if standardised:
            for level in (0.05, 0.05 / 57):
                bound = order.tests.threshold(level)
                truth |= {bound**2} if squared else {bound, -bound}
        assert dashed == truth


def legend_text(figure):
    (legend,) = figure.legends
    return [legend.get_title().get_text(), *(text.get_text() for text in legend.get_texts())]


def test_the_legend_states_the_levels_and_the_rule_of_naming(figures):
    plain = legend_text(figures["figure-07-residuals-r"])
    standardised = legend_text(figures["figure-07-residuals-r-standardised"])
    assert plain == [
        "named: significant at 5% per point or removed, at most 6 a panel",
        "kept",
        "removed by the elimination (5% family-wise)",
    ]
    assert standardised == [*plain, "5% family-wise", "5% per point"]


def test_figure_six_has_pixels_against_world_and_against_what_the_models_use(figures):
    figure = figures["figure-06-pixels"]
    *four, bar = figure.axes
    assert [ax.get_xlabel() for ax in four] == [
        "x [world units]",
        "y [world units]",
        "x/z, camera position subtracted [1]",
        "y/z, camera position subtracted [1]",
    ]
    assert [ax.get_ylabel() for ax in four] == ["r [px]", "c [px]", "r [px]", "c [px]"]
    assert bar.get_ylabel() == "depth z [world units]"
    points = bc.thesis()
    for ax, column, axis in zip(four, (0, 1, 0, 1), "rcrc", strict=True):
        (scatter,) = ax.collections
        x, t = scatter.get_offsets().T
        assert np.array_equal(t, points.pixel(axis))
        assert np.array_equal(scatter.get_array(), points.world[:, 2])
        if ax in four[:2]:
            assert np.array_equal(x, points.world[:, column])
        (low, high), (bottom, top) = ax.get_xlim(), ax.get_ylim()
        assert low < x.min() < x.max() < high
        assert bottom < t.min() < t.max() < top
    assert [names(ax) for ax in four] == [[], [], [6, 44], [1, 16, 19]]
    assert "model as written: r of order 4, c of order 1" in legend_text(figure)


def texts(figure):
    """Every text that is seen; matplotlib keeps tick labels beyond the limits, unseen."""
    unseen = set()
    for ax in figure.axes:
        for axis, (low, high) in ((ax.xaxis, ax.get_xlim()), (ax.yaxis, ax.get_ylim())):
            ticks = axis.get_major_ticks() + axis.get_minor_ticks()
            unseen |= {t for tick in ticks if not low <= tick.get_loc() <= high
                       for t in (tick.label1, tick.label2)}  # fmt: skip
    every = figure.findobj(match=Text)
    return [t for t in every if t.get_text() and t.get_visible() and t not in unseen]


@pytest.mark.parametrize("name", ["figure-06-pixels", *ERRORS])
def test_no_text_overlaps_another_or_is_cut_off(figures, name):
    figure = figures[name]
    figure.draw_without_rendering()
    # A line's box stands 12 % of its height above and below its digits.
    boxes = [
        (text.get_text(), text.get_window_extent().expanded(1, 0.76)) for text in texts(figure)
    ]
    assert len(boxes) > 20
    for text, box in boxes:
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1, text
        assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1, text
    for (one, a), (other, b) in combinations(boxes, 2):
        assert not a.overlaps(b), (one, other)


@pytest.mark.parametrize("name", ["figure-06-pixels", *ERRORS])
def test_no_name_covers_a_marker(figures, name):
    figure = figures[name]
    figure.draw_without_rendering()
    for ax in figure.axes:
        points = [p for line in ax.lines if line.get_marker() in ("o", "D")
                  for p in ax.transData.transform(line.get_xydata())]  # fmt: skip
        points += [p for c in ax.collections for p in ax.transData.transform(c.get_offsets())
                   if len(c.get_offsets()) > 1]  # fmt: skip
        for text in (t for t in ax.texts if isinstance(t, Annotation)):
            box = text.get_window_extent()
            assert not any(box.contains(*p) for p in points), (ax.get_title(loc="left"), text)


def test_the_same_figure_gives_the_same_bytes_without_a_date(reproduction, tmp_path):
    written = []
    for _ in range(2):
        figure = error_figure(reproduction, "c", ErrorKind(squared=False, standardised=False))
        save_figure(figure, tmp_path / "figure")
        written.append([(tmp_path / f"figure.{kind}").read_bytes() for kind in ("png", "svg")])
    assert written[0] == written[1]
    png, svg = written[0]
    assert png.startswith(b"\x89PNG")
    assert int.from_bytes(png[16:20], "big") == 7.2 * 300
    assert b"<dc:date>" not in svg


def test_other_data_gets_its_figures_too():
    """Exact data has no standardised residuals; the figures say so by leaving them out."""
    world = [[float(i), float(i % 4), 2.0 + i % 3] for i in range(12)]
    points = bc.Correspondences.from_arrays(world, [[x / z, y / z] for x, y, z in world])
    found = thesis_figures(bc.reproduce(points, orders=[1, 2]))
    figure = found["figure-09-squared-errors-r-standardised"]
    assert all(names(ax) == [] for ax in figure.axes)
    assert len(figure.axes) == 2  # both variants are the same model up to order 2


def test_a_per_point_level_is_drawn_as_such():
    found = bc.reproduce(bc.thesis(), orders=[1], per_point=True, significance=0.01)
    figure = error_figure(found, "r", ErrorKind(squared=True, standardised=True))
    assert legend_text(figure)[2] == "removed by the elimination (1% per point)"
    assert len(names(figure.axes[0])) <= NAMED
