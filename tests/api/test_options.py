"""Every public function takes the shared options, shows them, and refuses any other."""

from __future__ import annotations

import dataclasses
import inspect

import pytest

import bayescal as bc
from bayescal.comparison.settings import Settings

SHARED = {f.name: f.default for f in dataclasses.fields(Settings) if f.name != "defend"}
TAKING = [
    bc.compare,
    bc.fit,
    bc.compare_families,
    bc.fit_family,
    bc.compare_polynomials,
    bc.fit_polynomial,
]


@pytest.mark.parametrize("function", TAKING, ids=lambda f: f.__name__)
def test_each_option_is_shown_with_its_default_and_meaning(function):
    parameters = inspect.signature(function).parameters
    assert SHARED.items() <= {name: p.default for name, p in parameters.items()}.items()
    assert not any(p.kind is p.VAR_KEYWORD for p in parameters.values())
    section = inspect.getdoc(function).split("Parameters\n")[1].split("\nReturns\n")[0]
    explained = [
        name
        for entry in section.splitlines()
        if not entry.startswith((" ", "-")) and entry
        for name in entry.split(" : ")[0].split(", ")
    ]
    assert explained == list(parameters)  # each once, in the order of the signature


def test_what_is_shown_is_what_is_taken():
    x, y = range(8), [0.0, 1.1, 1.9, 3.2, 4.0, 5.1, 5.8, 7.2]
    wanted = Settings(sigma=0.5, prior="field", tau=0.1, seed=3, ess=200)
    asked = dataclasses.asdict(wanted)
    del asked["defend"]
    assert bc.compare_polynomials(x, y, [1], **asked).settings == wanted


@pytest.mark.parametrize("name", ["sgima", "defend"])
def test_any_other_option_is_refused(name):
    with pytest.raises(TypeError, match=name):
        bc.fit(bc.thesis(), 1, **{name: True})
    with pytest.raises(TypeError, match=name):
        bc.fit_polynomial([1, 2, 3, 4], [1, 2, 3, 5], 1, **{name: True})
