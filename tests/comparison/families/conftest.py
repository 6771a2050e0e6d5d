"""A comparison of all families that several tests look at."""

import pytest

import bayescal as bc


@pytest.fixture(scope="package")
def thesis_families():
    return bc.compare_families(
        bc.thesis(), ["separable", "bivariate", "pinhole"], [1, 4], radial_orders=[0, 1], ess=400
    )
