"""Maps over the image against predictions made one by one, and differences worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy import stats

import bayescal as bc
from bayescal.points.bundled import chessboard
from bayescal.prediction.maps import FITTED, NAMES, ModelDifference, image_maps
from bayescal.prediction.sights import image_grid, sights


@pytest.fixture(scope="module")
def camera(thesis_comparison) -> bc.CalibratedCamera:
    return bc.camera(thesis_comparison)


@pytest.fixture(scope="module")
def maps(camera):
    return image_maps(camera, columns=9, rows=7)


def test_what_a_place_looks_at_appears_there(camera, maps):
    """Truth: the chosen model's mean, at the points the places look at; 1e-9 px of 1000."""
    at = maps.places
    found = bc.predict(camera, at.world[at.found], average=False)
    np.testing.assert_allclose(found.mean, at.pixels[at.found], rtol=0, atol=1e-8)
    assert (at.inside == (at.found & ~_extrapolated(camera, at))).all()
    assert 0 < at.inside.sum() < at.found.sum() < len(at.found)  # order 4 turns before the edge


def _extrapolated(camera, at):
    out = np.ones(len(at.found), dtype=bool)
    one = bc.camera(camera, model=camera.chosen.name)
    out[at.found] = bc.predict(one, at.world[at.found]).extrapolated
    return out


def test_deviations_are_those_of_predictions(camera, maps):
    seen = maps.places.found
    for average, values in ((False, maps.epistemic), (True, maps.averaged)):
        found = bc.predict(camera, maps.places.world[seen], average=average)
        np.testing.assert_allclose(values[seen], np.sqrt((found.sd**2).mean(axis=1)))
    assert np.isnan(maps.epistemic[~seen]).all()
    assert (maps.predictive[seen] > maps.epistemic[seen]).all()


def test_the_worst_corner_is_worked_out_directly(camera, maps):
    """Truth: both Legendre series at the corner's x/z; draws of order 5 less their best order 4."""
    one = next(d for d in maps.named.differences if d.other == "separable (5, 1)")
    four, five = camera.chosen, camera.only("separable (5, 1)").chosen
    assert four.name == "separable (4, 1)"
    worst = 5 + int(np.nanargmax(one.size[5:]))
    position = np.array(bc.thesis().setup.position)

    def scaled(world):
        away = world - position
        return four.domains[0].scale(away[..., 0] / away[..., 2])

    s = scaled(maps.named.places.world[worst])
    b4, b5 = four.parameters.mean[:5], five.parameters.mean[:6]
    shift = legendre.legval(s, b5) - legendre.legval(s, b4)
    assert one.shift[worst, 0] == pytest.approx(shift, abs=1e-9)
    grid = sights(camera, image_grid(camera, *FITTED))
    at = scaled(grid.world[grid.inside])
    left = []
    for b in five.parameters.draws[:, :6]:
        fitted = legendre.legfit(at, legendre.legval(at, b), 4)
        left.append(legendre.legval(s, b) - legendre.legval(s, fitted))
    # Both have order 1 along c: the corner moves along r alone, up to the spread of beta.
    assert one.sd[worst] == pytest.approx(np.std(left), rel=0.01)
    words = next(text for text in maps.sentences if "(5, 1)" in text)
    assert f"{NAMES[worst].removesuffix(' corner')}, extrapolated" in words
    assert one.sd[worst] > one.size[worst]
    assert f"by up to {one.size[worst] + 2 * one.sd[worst]:.0f} px (95%)" in words


def test_a_difference_below_its_deviation_is_said_by_its_bound():
    """Truths: 5 px by Pythagoras; a normal of a mean up to its sd stays within 2 sd more at 95%."""
    shift = np.array([[3.0, 4.0], [3.0, 4.0], [0.03, 0.04], [np.nan, np.nan]])
    found = ModelDifference("a", "b", 0.2, shift, np.array([0.82, 47.0, 660.0, np.nan]))
    assert [found.told(i) for i in range(4)] == ["5.00 ± 0.82", "<99", "<1300", ""]
    for mean in (0.0, 0.5, 1.0):
        assert stats.norm.cdf(2.0) - stats.norm.cdf(-2 * mean - 2) > 0.95


def test_maps_of_a_lens_take_out_the_turn(lens_comparison):
    """Truth: the projection's deviation at infinity as the lens comparison has it."""
    camera = bc.camera(lens_comparison)
    maps = image_maps(camera, columns=5, rows=4)
    for place in lens_comparison.places:
        i = NAMES.index(place.name)
        assert maps.named.epistemic[i] == pytest.approx(place.infinity, rel=5 / np.sqrt(2000))
    assert maps.places.found.all()
    assert maps.differences == ()


def test_averaged_lenses_have_their_own_variances_and_that_between_them():
    """Truth: draws of all probable lenses, where they are near enough to be linear."""
    found = bc.calibrate(chessboard(), lenses=["radial 2 + p", "radial 3 + p"], ess=500)
    assert found.lenses[1].probability > 0.1
    maps = image_maps(bc.camera(found, average=True), columns=5, rows=4)
    edges = [place for place in found.places if "edge" in place.name]
    own = max(maps.named.epistemic[NAMES.index(place.name)] for place in edges)
    assert max(place.infinity for place in edges) > 1.5 * own
    for place in edges:
        drawn = maps.named.averaged[NAMES.index(place.name)]
        assert place.infinity == pytest.approx(drawn, rel=0.1)


@pytest.mark.parametrize("kind", ["sd-map", "difference-map"])
def test_maps_are_drawn(maps, kind):
    from bayescal.report.figures.registry import KINDS

    figure = KINDS[kind].draw(maps)
    assert len([panel for panel in figure.axes if panel.axison]) == (3 if kind == "sd-map" else 4)
    assert "px" in KINDS[kind].alt_text(maps)
    bottom, top = figure.axes[0].get_ylim()
    assert bottom > top  # recorded rows are counted from the top, whatever the models do


def test_a_single_model_has_no_differences(lens_comparison):
    camera = bc.camera(lens_comparison)
    with pytest.raises(bc.InputError, match="one alone"):
        bc.plot(camera, "difference-map")
    with pytest.raises(bc.InputError, match="no kind of figure of camera"):
        bc.plot(camera, "verdict")
