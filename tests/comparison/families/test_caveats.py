"""What limits a verdict across families is said, and only then."""

from dataclasses import replace

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.families.caveats import family_findings
from bayescal.points.camera import StatedCamera
from tests.helpers.cameras import TURNED, turned_points


def test_a_default_prior_of_the_position_is_said_to_matter(thesis_families):
    """Only where it decides anything: with both treatments compared, and none stated."""
    caveats = thesis_families.verdict.caveats
    assert any("position depends on its prior's sd" in c and "2.1 nat" in c for c in caveats)


def test_a_default_prior_of_the_orientation_is_said_to_matter(thesis_families):
    """Where pinholes have rivals and may lose; what a stated one costs is for its user to know."""
    found = thesis_families
    assert 0.001 < found.verdict.families["pinhole"] < 0.999
    assert any("orientation's prior" in caveat for caveat in found.verdict.caveats)
    camera = replace(found.points.setup.camera, orientation_sd=(30.0, 30.0, 30.0))
    stated = replace(found.points, setup=replace(found.points.setup, camera=camera))
    caveats = [finding.text for finding in family_findings(stated, found.models)]
    assert not any("orientation's prior" in caveat for caveat in caveats)


def test_a_camera_far_from_where_its_priors_expect_it_is_said():
    """The orientation stated to a degree is 7 degrees off, and the focal length twice too long."""
    points = turned_points(0.06)
    camera = StatedCamera(
        position_sd=(50.0, 50.0, 50.0), orientation=(37.0, 0.0, 0.0),
        orientation_sd=(1.0, 1.0, 1.0), focal=6000.0, focal_log_sd=0.1,
    )  # fmt: skip
    off = replace(points, setup=replace(points.setup, camera=camera))
    said = [c for c in bc.fit_family(off, "pinhole", (1,), ess=400).verdict.caveats if "sds" in c]
    assert any(c.startswith("the rotation found is ") for c in said)
    assert any(c.startswith("the focal length found is ") for c in said)
    right = bc.fit_family(points, "pinhole", (1,), ess=400).verdict.caveats
    assert not any("prior and data disagree" in caveat for caveat in right)


def test_a_narrow_prior_that_agrees_with_the_points_is_no_disagreement():
    """The likelihood alone is unsure of the position by more than that prior."""
    points = turned_points(0.06)
    true = replace(points.setup, position=TURNED["position"])
    camera = replace(true.camera, position_sd=(1e-4, 1e-4, 1e-4))
    points = replace(points, setup=replace(true, camera=camera))
    for family, orders in (("pinhole", (1,)), ("separable", (1, 1))):
        found = bc.fit_family(points, family, orders, position="free", ess=100)
        said = any("position found" in caveat for caveat in found.verdict.caveats)
        assert said == (family == "separable"), "which is far from looking along z"


@pytest.mark.parametrize("position", ["free", "stated"])
def test_a_sigma_at_the_bound_of_its_prior_is_said(position):
    """Of draws, and in closed form."""
    points = bc.thesis()
    scattered = points.pixels + np.random.default_rng(0).normal(0, 5000, (57, 2))
    near = StatedCamera(position_sd=(1.0, 1.0, 1.0))  # noise alone would let it go anywhere
    wide = replace(points.setup, width=1e5, height=1e5, camera=near)
    off = replace(points, pixels=scattered, setup=wide)
    found = bc.fit_family(off, "separable", (1, 1), position=position, ess=100)
    assert (found.best.posterior is None) == (position == "stated")
    assert any(
        "sigma_r's posterior lies at its bound, 1000 px" in caveat
        for caveat in found.verdict.caveats
    )
    plain = bc.fit_family(points, "separable", (1, 1), position=position, ess=100)
    assert not any("its bound" in caveat for caveat in plain.verdict.caveats)
