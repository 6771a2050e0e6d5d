"""Every kind of figure on awkward comparisons: drawn, or refused with the reason."""

from __future__ import annotations

import io
import subprocess
import sys
import warnings

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.image import imread

import bayescal as bc
from bayescal.errors import InputError
from bayescal.points.setup import StatedPrior
from bayescal.report.figures.labels import printable_names
from bayescal.report.figures.registry import KINDS
from bayescal.report.figures.style import figure_bytes
from tests.helpers.cases import camera_points
from tests.helpers.command import environment

CJK, EMOJI, REVERSED = "\u6771\u4eac", "\U0001f4f7", "\u202eabc"
HOSTILE = ("<script>", "$x_{", "a" * 500, CJK, EMOJI, "a&b", "\\frac", REVERSED)
RNG = np.random.default_rng(8)
X = np.linspace(-1, 1, 12)
Y = X**2 + 0.1 * RNG.standard_normal(12)

OF_ORDERS = [kind for kind in KINDS.values() if kind.of == "comparison"]


def stated() -> bc.Correspondences:
    prior = StatedPrior((960.0, 700.0, 0.0), (100.0, 100.0, 10.0))
    points = camera_points(15, noise=2.0)
    setup = bc.Setup(width=1920.0, height=1080.0, priors={"r": prior, "c": prior})
    return bc.Correspondences.from_arrays(points.world, points.pixels, setup=setup)


def hostile() -> bc.Correspondences:
    n, places = 80, np.arange(3, 80, 10)
    shift, labels = np.zeros(n), [str(i) for i in range(n)]
    shift[places] = 90.0 * (-1) ** np.arange(len(places))
    for place, label in zip(places, HOSTILE, strict=True):
        labels[place] = label
    return camera_points(n, noise=1.0, shift=shift, labels=tuple(labels))


def compare_once(points, orders, **options):
    return lambda: bc.compare(points(), orders, ess=100, **options)


MAKERS = {
    "three points": compare_once(lambda: camera_points(3, noise=1.0), [1], axis="c", defend=True),
    "no freedom": compare_once(lambda: camera_points(3, noise=1.0), [1, 2], axis="r", defend=True),
    "exact": compare_once(lambda: camera_points(9, noise=0.0), [1, 2], sigma=1.0),
    "flat": compare_once(lambda: camera_points(15, noise=2.0), [1, 2], prior="flat", defend=True),
    "stated": compare_once(stated, [1, 2], defend=True),
    "fixed tau": compare_once(lambda: camera_points(15), [1, 2], tau=0.01, axis="r"),
    "hostile": compare_once(hostile, [1]),
    "own deviations": compare_once(
        lambda: camera_points(15, sigma_r=np.full(15, 1.0), sigma_c=np.full(15, 2.0)), [1, 2]
    ),
    "generic": lambda: bc.compare_polynomials(
        X, X**2 + 0.1 * RNG.standard_normal(12), [1, 2], ess=100
    ),
    # Where tau is inferred, the resamples of so many orders take half a minute.
    "twenty orders": compare_once(
        lambda: camera_points(40, noise=2.0), range(1, 21), axis="r", tau=0.02
    ),
}
FLAT = "flat prior"
ONE_AXIS = ("three points", "no freedom", "fixed tau", "generic", "twenty orders")
# Why a kind can't be drawn of a comparison: a part of what it says.
REASONS = {
    ("three points", "qq"): "too few",
    ("no freedom", "qq"): "too few",
    ("exact", "qq"): "rounding only",
    ("flat", "joint"): FLAT,
    ("flat", "evidence"): FLAT,
    ("flat", "bootstrap"): FLAT,
    **{(name, "joint"): "both axes" for name in ONE_AXIS},
    ("generic", "other"): "x alone",
    ("generic", "image"): "x alone",
}


@pytest.fixture(scope="module", params=list(MAKERS), ids=lambda name: name.replace(" ", "-"))
def case(request):
    return request.param, MAKERS[request.param]()


def test_every_kind_is_drawn_or_says_why_not(case):
    name, comparison = case
    axis = next(iter(comparison.axes))
    for kind in OF_ORDERS:
        large = kind.name in ("corner", "trace")  # a panel per parameter, or per pair
        if large and name not in ("three points", "exact", "generic"):
            continue
        order = 1 if large else None
        wanted = axis if kind.one_axis else None
        reason = REASONS.get((name, kind.name))
        if reason is not None:
            for act in (kind.draw, kind.alt_text):
                with pytest.raises(InputError, match=reason) as refused:
                    act(comparison, wanted, order)
                assert "\n" not in str(refused.value)
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            made = figure_bytes(kind.draw(comparison, wanted, order), "svg")
        assert made.startswith(b"<?xml")
        assert b">nan" not in made
        assert b"[U+" not in made
        text = kind.alt_text(comparison, wanted, order)
        assert text == text.strip()
        assert "nan" not in text.split()
        assert "\n" not in text


def test_flat_prior_shows_bic(case):
    name, comparison = case
    if name != "flat":
        return
    for panel, axis in zip(
        KINDS["verdict"].draw(comparison).axes, comparison.axes.values(), strict=True
    ):
        bic = np.array([result.criteria.bic for result in axis.orders])
        np.testing.assert_allclose([bar.get_height() for bar in panel.patches], bic - bic.min())


def test_many_points_keep_an_svg_small():
    comparison = bc.compare(camera_points(5000, noise=2.0), [1], ess=100)
    for kind in ("residuals", "other", "image", "qq", "curve"):
        made = figure_bytes(KINDS[kind].draw(comparison, "r"), "svg")
        assert len(made) < 400_000, kind


def test_labels_that_can_not_be_shown_become_numbers():
    names = printable_names(HOSTILE)
    assert names == ("<script>", "$x_{", "#3", "#4", "#5", "a&b", "\\frac", "#8")


def test_a_hostile_label_is_written_as_it_is():
    comparison = bc.compare(hostile(), [1], axis="r", ess=100)
    figure = KINDS["residuals"].draw(comparison, "r")
    notes = {text.get_text(): text for text in figure.axes[0].texts}
    numbers = {"a" * 500: "#24", CJK: "#34", EMOJI: "#44", REVERSED: "#74"}
    assert set(notes) == {numbers.get(label, label) for label in HOSTILE}
    assert not any(note.get_parse_math() for note in notes.values())
    described = KINDS["residuals"].alt_text(comparison, "r")
    assert "<script> (" in described


@pytest.fixture(scope="module")
def small():
    return bc.compare(camera_points(20, noise=2.0), [1, 2], ess=100, defend=True)


@pytest.mark.parametrize("kind", [kind.name for kind in OF_ORDERS])
def test_same_bytes_whatever_the_users_own_settings(small, kind):
    axis = "r" if KINDS[kind].one_axis else None
    made = figure_bytes(KINDS[kind].draw(small, axis), "svg")
    with mpl.rc_context({"font.size": 21, "figure.facecolor": "black", "svg.hashsalt": None}):
        again = figure_bytes(KINDS[kind].draw(small, axis), "svg")
    assert again == made


@pytest.mark.parametrize("suffix", ["png", "pdf"])
def test_same_bytes_in_other_formats(small, suffix):
    made = [figure_bytes(KINDS["residuals"].draw(small, "r"), suffix) for _ in range(2)]
    assert made[0] == made[1]
    assert b"CreationDate" not in made[0]


def test_white_behind_every_figure(small):
    stream = figure_bytes(KINDS["verdict"].draw(small), "png", dpi=50)
    pixels = imread(io.BytesIO(stream))
    np.testing.assert_array_equal(pixels[0, 0], 1.0)


@pytest.mark.parametrize(
    ("kind", "options", "reason"),
    [
        ("nonsense", {}, "kinds: verdict"),
        ("residuals", {}, "needs an axis, one of r, c"),
        ("residuals", {"axis": "y"}, "axes: r, c"),
        ("residuals", {"axis": "r", "order": 7}, "orders: 1, 2"),
        ("evidence", {"axis": "r", "order": 1}, "leave out the order"),
        ("image", {"order": 1}, "needs an axis"),
    ],
)
def test_what_plot_refuses(small, kind, options, reason):
    with pytest.raises(InputError, match=reason):
        bc.plot(small, kind, **options)


def test_plot_is_the_kinds_own_drawing(small):
    figure = bc.plot(small, "curve", axis="r", order=2)
    assert figure_bytes(figure, "svg") == figure_bytes(KINDS["curve"].draw(small, "r", 2), "svg")


def test_pyplot_knows_nothing_of_it(small):
    code = (
        "import sys; import bayescal as bc; from tests.helpers.cases import camera_points; "
        "r = bc.compare(camera_points(9), [1], axis='r', ess=100); bc.plot(r, 'residuals'); "
        "print('matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment(), capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"
    assert small.sound
