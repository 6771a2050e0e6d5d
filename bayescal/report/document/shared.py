"""What the JSON documents share: provenance, points, parameters, the way they are written."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from bayescal.arrays import finite
from bayescal.comparison.faces.convert import Converts
from bayescal.comparison.finding import Finding
from bayescal.inference.correlation import correlation_of
from bayescal.inference.posterior import INTERVAL_PROBABILITY, ParameterSummary, Posterior
from bayescal.points.correspondences import Correspondences
from bayescal.points.heading import Heading
from bayescal.version import __version__

if TYPE_CHECKING:  # Gaussian noise samples nothing of the kind
    from bayescal.comparison.settings import Settings

# What the numbers of a sampled result depend on.
PACKAGES = ("emcee", "numpy", "scipy", "arviz_stats")


def dumps(found: dict[str, Any]) -> str:
    """Format a document as JSON text; refuses NaN."""
    return json.dumps(found, indent=1, allow_nan=False, ensure_ascii=True) + "\n"


def schema(kind: str, package: str = __package__) -> dict[str, Any]:
    """JSON Schema of a kind's document, such as ``"comparison"``, that lies in a package."""
    text = files(package).joinpath(f"{kind}.schema.json").read_text(encoding="utf-8")
    loaded: dict[str, Any] = json.loads(text)
    return loaded


def provenance(
    command: str, settings: Settings | None = None, packages: Sequence[str] = PACKAGES
) -> dict[str, Any]:
    """Say how, by what and when a document was made."""
    sampled = {} if settings is None else {"seed": settings.seed, "ess": settings.ess}
    return {
        **versions(packages),
        "command": command,
        **sampled,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def versions(packages: Sequence[str] = PACKAGES) -> dict[str, str]:
    """Versions of this program, of Python and of what the numbers depend on."""
    return {
        "bayescal": __version__,
        "python": platform.python_version(),
        **{name: version(name) for name in packages},
    }


def points_facts(points: Correspondences) -> dict[str, Any]:
    """Collect what a document says of the points and the camera."""
    setup = points.setup
    return {
        "source": points.source,
        "sha256": points.sha256,
        "n_points": points.n,
        **({} if points.drawn_from is None else {"n_held": len(points)}),
        "image": {"width_px": setup.width, "height_px": setup.height},
        "camera_position": list(setup.position),
        "c_from_bottom": setup.c_from_bottom,
        "assumed": list(setup.assumed),
    }


def stated_heading(document: Mapping[str, Any]) -> Heading:
    """Give what a document says for the title block."""
    said = document.get("report") or {}
    return Heading(**{name: text for name, text in said.items() if text})


def covariance_facts(found: Converts) -> dict[str, Any]:
    """Give how the parameters of a model move together; null beside one that does not vary."""
    names, matrix = found.named_covariance()
    rho = [[finite(value) for value in row] for row in correlation_of(matrix).tolist()]
    return {"parameters": list(names), "matrix": matrix.tolist(), "correlation": rho}


def findings_facts(findings: Iterable[Finding]) -> list[dict[str, str]]:
    """Give findings with their kind and severity."""
    return [{"kind": f.kind, "severity": f.severity.name.lower(), "text": f.text} for f in findings]


def summary_facts(p: ParameterSummary) -> dict[str, Any]:
    """Collect what a document says of a sampled parameter beside its name."""
    return {
        "mean": p.mean,
        "sd": p.sd,
        **interval_facts(p.interval),
        "mcse_mean": finite(p.mcse_mean),
        "ess_bulk": finite(p.ess_bulk),
        "ess_tail": finite(p.ess_tail),
        "rhat": finite(p.rhat),
    }


def interval_facts(interval: tuple[float, float]) -> dict[str, Any]:
    """Give a central interval with its probability."""
    return {"interval": list(interval), "interval_probability": INTERVAL_PROBABILITY}


def evidence_facts(posterior: Posterior) -> dict[str, Any] | None:
    """Collect what tells whether to trust a sampled evidence; None for a closed form."""
    if posterior.estimate is None:
        return None
    found = asdict(posterior.estimate)
    found["warnings"] = list(found["warnings"])
    shown = {k: finite(v) if isinstance(v, float) else v for k, v in found.items()}
    return {**shown, "trusted": posterior.estimate.certain, "modes": len(posterior.modes)}


def by_order(found: Mapping[int, Any]) -> dict[str, Any]:
    """Give values of orders under their names in JSON."""
    return {str(k): list(v) if isinstance(v, tuple) else v for k, v in found.items()}
