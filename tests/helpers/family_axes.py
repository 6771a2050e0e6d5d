"""Both axes of the thesis data in a linear family, with sigma inferred."""

from __future__ import annotations

import bayescal as bc
from bayescal.comparison.orders.axis import Axis
from bayescal.noise.level import NoiseLevel
from tests.helpers.problems import field_rule


def axes(family):
    made = [family.axis_data(bc.thesis(), a) for a in "rc"]
    return tuple(axis_of(d, NoiseLevel.inferred()) for d in made)


def axis_of(data, level):
    return Axis(data, level, "", field_rule(data), "", highest=4)
