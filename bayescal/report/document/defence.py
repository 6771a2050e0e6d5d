"""The answers to a referee, in the document of a comparison."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from bayescal.comparison.judged import Weighed
from bayescal.report.document.shared import by_order

if TYPE_CHECKING:  # a comparison without a defence does not pay for it
    from bayescal.comparison.adequacy.outcome import AdequacyTest
    from bayescal.comparison.defence.results import Defence
    from bayescal.comparison.defence.stability import Bootstrap, Removal


def defence_document(defence: Defence) -> dict[str, Any]:
    """Collect a defence's numbers as JSON values."""
    tau = defence.tau
    beyond = defence.beyond
    return {
        "tau_sensitivity": None
        if tau is None
        else {
            "tau": tau.tau.tolist(),
            "orders": list(tau.orders),
            "log_evidence": tau.log_evidence.tolist(),
            "probability": tau.probability.tolist(),
            "wins": [{"order": w.order, "tau": [w.lower, w.upper]} for w in tau.wins],
            "possible": [{"order": w.order, "tau": [w.lower, w.upper]} for w in tau.possible],
        },
        "groups": defence.group_source,
        "points_that_matter": removal_rows(defence.points_that_matter),
        "further_points_that_matter": defence.further_points,
        "groups_that_matter": removal_rows(defence.groups_that_matter),
        "bootstrap": [_bootstrap(b) for b in defence.resampled],
        "beyond": None
        if beyond is None
        else {
            "probability": by_order(beyond.probability),
            "winner": beyond.winner,
        },
        "noises": noises_document(defence.noises),
        "worth": [
            {"order": w.order, "largest_px": w.largest, "sd_px": w.sd, "at": w.at}
            for w in defence.worth
        ],
    }


def removal_rows(removals: Sequence[Removal]) -> list[dict[str, Any]]:
    """Give points or groups whose removal changes the winner, an order or a model's name."""
    return [
        {
            "name": removal.name,
            "points": removal.size,
            "order": removal.order if isinstance(removal.order, int) else str(removal.order),
            "log_bayes_factor": removal.log_bayes_factor,
        }
        for removal in removals
    ]


def _bootstrap(found: Bootstrap) -> dict[str, Any]:
    return {"unit": found.unit, "resamples": found.resamples, "share": by_order(found.share)}


def noises_document(noises: Sequence[Weighed]) -> list[dict[str, Any]]:
    """Evidence of an order under other noise models, for the result document."""
    return [
        {
            "noise": found.key.noise,
            "log_evidence": {found.key.order: found.log_evidence},
            "log_evidence_error": {found.key.order: found.log_evidence_error},
            "warnings": {found.key.order: list(found.warnings)} if found.warnings else {},
        }
        for found in noises
    ]


def adequacy_rows(tests: Sequence[AdequacyTest]) -> list[dict[str, Any]]:
    """Give tests as JSON values: what is unavailable is None, never NaN."""
    return [
        {
            "name": test.name,
            "statistic": test.statistic,
            "value": test.value,
            "dof": None if test.dof is None else list(test.dof),
            "p_value": test.p_value,
            "p_adjusted": test.p_adjusted,
            "concern": test.concern,
            "meaning": test.meaning,
            "parts": adequacy_rows(test.parts),
        }
        for test in tests
    ]
