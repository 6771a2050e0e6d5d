"""The numbers in a verdict's words are those of the result document."""

from __future__ import annotations

import dataclasses
import math
import re

from bayescal.comparison.results import AxisComparison
from tests.helpers.cases import axis_document


def numbers_of(value, key="") -> list[float]:
    """Every number of a document, with what the text makes of it: %, px, 2 ln B."""
    if isinstance(value, dict):
        return [x for k, v in value.items() for x in numbers_of(v, k)]
    if isinstance(value, list):
        return [x for v in value for x in numbers_of(v, key)]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return []
    scaled = [abs(value)]
    if key == "log_bayes_factor_to_next":
        scaled.append(2 * abs(value))
    if key in ("probability", "share", "tau", "") or key.isdigit():
        scaled.append(100 * abs(value))
    return scaled


def unexplained(axis: AxisComparison) -> list[str]:
    """Numbers of the verdict's text that no number of the document rounds to."""
    document = axis_document(axis)
    size, n = document["prior"]["size_px"], document["n"]
    known = numbers_of(document)
    for win in (document["defence"]["tau_sensitivity"] or {"possible": []})["possible"]:
        known += [tau * size for tau in win["tau"]]
    known += [math.log(n), 95.0, 99.9, 0.1, 100.0, 2.0, 4.0]  # ln n; levels and limits
    text = document["verdict"]["text"].replace("2 ln B", "")
    text = re.sub(r"point \S+|group [^(]+", "", text)
    out = []
    for token in re.findall(r"(?<![\w.])\d[\d.]*(?:e[+-]?\d+)?", text):
        number = token.rstrip(".")
        digits, _, exponent = number.partition("e")
        places = len(digits.partition(".")[2])
        step = 10.0 ** (int(exponent or 0) - places)
        if float(number) >= 1000 and not places:
            step = 100.0  # rounded to two digits
        if not any(abs(float(number) - v) <= 0.501 * step for v in known):
            out.append(number)
    return out


def test_every_number_of_the_text_is_in_the_result_document(weak_curve, one_bad_group):
    assert unexplained(weak_curve) == []
    assert unexplained(one_bad_group) == []


def test_a_number_that_is_not_in_the_document_would_show(weak_curve):
    """Negative control: 2 ln B and the lead of leave-one-out, both far off."""
    text = "\n".join(weak_curve.verdict.sentences)
    wrong = re.sub(r"2 ln B = [\d.]+", "2 ln B = 7777.7", text)
    wrong = re.sub("(ahead|behind) by ", r"\1 by 88", wrong, count=1)
    verdict = dataclasses.replace(weak_curve.verdict, sentences=tuple(wrong.split("\n")))
    assert len(unexplained(dataclasses.replace(weak_curve, verdict=verdict))) == 2
