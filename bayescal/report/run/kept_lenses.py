"""What takes long about lenses over many views, as a file of their run: arrays with a JSON head."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from bayescal.arrays import Array, from_npz, to_npz
from bayescal.calibration.error_grid import Averaged
from bayescal.calibration.judge import LensEvidence, Setting
from bayescal.calibration.least_squares import Fit, with_bow
from bayescal.calibration.stacking import Poses
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
from bayescal.comparison.judged import with_probabilities
from bayescal.comparison.lenses.candidates import named_candidates
from bayescal.comparison.lenses.fitted import judged_lens
from bayescal.comparison.lenses.gross_error import GrossError
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.results import JudgedLens, LensComparison
from bayescal.inference.estimate import EvidenceEstimate


def lenses_bytes(found: LensComparison) -> bytes:
    """Encode fits, evidences, views left out, and what is drawn of the best lens."""
    drawn = found.drawn
    arrays = {"draws": drawn.draws, "covariance": drawn.covariance}
    if found.setting.data.levels is not None:
        arrays["levels"] = found.setting.data.levels
    arrays |= {f"half.{i}": half for i, half in enumerate(drawn.halves)}
    head = {
        "impossible": found.impossible,
        "failures": found.failures,
        "gross": [asdict(point) for point in found.gross],
        "lenses": [_packed(judged, f"{i}.", arrays) for i, judged in enumerate(found.lenses)],
    }
    return to_npz(head, arrays)


def _packed(judged: JudgedLens, at: str, arrays: dict[str, Array]) -> dict[str, Any]:
    """Put a lens's arrays beside the others; give what is no array."""
    fit, problem, evidence = judged.fit, judged.evidence.problem, judged.evidence
    for name, x, poses in (("fit", fit.x, fit.poses), ("mode", problem.x, problem.poses)):
        arrays[f"{at}{name}"] = x
        arrays[f"{at}{name}.rotation"] = poses.rotation
        arrays[f"{at}{name}.translation"] = poses.translation
    if judged.loo is not None and judged.without is not None:
        arrays[f"{at}left_out"] = judged.loo.pointwise
        arrays[f"{at}without"] = judged.without
    return {
        "name": judged.name,
        "sum_of_squares": fit.sum_of_squares,
        "converged": fit.converged,
        "errors": asdict(evidence.errors),
        "estimate": asdict(evidence.estimate),
        "log_evidence": evidence.log_evidence,
    }


class KeptLenses:
    """What `lenses_bytes` encoded.

    Raises
    ------
    ValueError
        Where it is no such file, or is damaged.
    """

    def __init__(self, raw: bytes) -> None:
        self.head, self._arrays = from_npz(raw)

    def names(self, what: str) -> tuple[str, ...]:
        """Lenses that were impossible, or failures."""
        return tuple(self.head[what])

    @property
    def gross(self) -> tuple[GrossError, ...] | None:
        """Points further off than the errors allow; None in runs from before they were kept."""
        kept = self.head.get("gross")
        if kept is None:
            return None
        return tuple(GrossError(**{**point, "shift": tuple(point["shift"])}) for point in kept)

    @property
    def levels(self) -> Array | None:
        """Noise of each view over the usual; None where all are alike."""
        return self._arrays.get("levels")

    @property
    def draws(self) -> Array:
        """Draws of the best lens, the error models averaged."""
        return self._arrays["draws"]

    @property
    def covariance(self) -> Array:
        """Covariance of the same."""
        return self._arrays["covariance"]

    @property
    def halves(self) -> tuple[Array, ...]:
        """Fits of the best lens to halves of the views."""
        return tuple(self._arrays[f"half.{i}"] for i in (0, 1) if f"half.{i}" in self._arrays)

    def lenses(self, setting: Setting, request: LensRequest) -> tuple[JudgedLens, ...]:
        """Give the lenses as they were judged, the most probable first."""
        found = [
            self._lens(kept, f"{i}.", setting, request)
            for i, kept in enumerate(self.head["lenses"])
        ]
        return with_probabilities(found)

    def _lens(
        self, kept: dict[str, Any], at: str, setting: Setting, request: LensRequest
    ) -> JudgedLens:
        (candidate,) = named_candidates([kept["name"]])
        model = candidate.model(setting.data.size, square=request.square, centred=request.centred)
        x, poses = self._placed(f"{at}fit")
        fit = Fit(x, poses, kept["sum_of_squares"], kept["converged"])
        errors = kept["errors"]
        nodes = tuple((n[0], n[1], n[2], n[3]) for n in errors["nodes"])
        averaged = Averaged(
            errors["log_evidence"], nodes, tuple(errors["weights"]), errors["tried"]
        )
        bowed = with_bow(fit, model)[0] if setting.bow else model
        problem = setting.problem(bowed, *self._placed(f"{at}mode"), nodes[0])
        stated = kept["estimate"]
        estimate = EvidenceEstimate(**{**stated, "warnings": tuple(stated["warnings"])})
        evidence = LensEvidence(averaged, problem, estimate, kept["log_evidence"])
        loo = without = None
        if f"{at}without" in self._arrays:
            terms, without = (self._arrays[f"{at}{name}"] for name in ("left_out", "without"))
            loo = LeaveOneOut(terms, refitted=tuple(range(len(terms))))
        return judged_lens(candidate, model, fit, setting, evidence, loo, without)

    def _placed(self, name: str) -> tuple[Array, Poses]:
        rotation, translation = (
            self._arrays[f"{name}.{part}"] for part in ("rotation", "translation")
        )
        return np.asarray(self._arrays[name]), Poses(rotation, translation)
