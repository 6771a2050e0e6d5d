"""What to do about a finding: the next step, by the finding's kind."""

from __future__ import annotations

from collections.abc import Iterable

from bayescal.comparison.finding import Finding

OTHER_MODELS = "bayescal compare --family separable,bivariate,pinhole --position stated,free"
# By the beginning of a finding's kind.
ADVICE = {
    "geometry": "correct the setup: camera position, c_from_bottom, the frame of the world points",
    "another-model": OTHER_MODELS,
    "chi-squared": "check the stated sigma against --sigma inferred",
    "edge": "compare more orders (--orders, --radial-orders)",
    "sigma-bound": "check the unit of the readings and the image size",
    "tau-bound": "check the image size, or state tau",
    "world-errors": "measure the world points better: their errors flatten the curve",
    "draws": "report this: the program disagrees with itself",
    "misfit: chi2": "check the stated sigma against --sigma inferred",
    "misfit: lack of fit": OTHER_MODELS,
    "misfit: other coordinate": OTHER_MODELS,
    "misfit: surface": "a richer lens model: bayescal calibrate knows more of them",
    "misfit: neighbours": "name what shares errors in a column group, and believe it by group",
    "misfit: shared errors": "name what shares errors in a column group, and believe it by group",
    "misfit: normality": "bayescal outliers",
    "misfit": "read the caveats",
    "noise": "bayescal outliers",
    "convergence": "sample longer (--ess)",
    "evidence": "sample longer (--ess)",
}


def next_step(findings: Iterable[Finding]) -> str:
    """Say what to do about the gravest finding that anything can be done about; findings in order.

    Empty where there is none.
    """
    for found in findings:
        for kind, words in ADVICE.items():
            if found.kind.startswith(kind):
                return words
    return ""
