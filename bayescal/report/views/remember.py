"""Three lines to remember of a defended comparison."""

from __future__ import annotations

from collections.abc import Mapping

from bayescal.comparison.finding import ordered
from bayescal.comparison.findings.advice import next_step
from bayescal.comparison.verdict import Verdict
from bayescal.report.blocks import Listing, Part
from bayescal.rounding import percent

ENOUGH = "nothing: use it"


def remembered(verdicts: Mapping[str, Verdict]) -> Part:
    """Say what is recommended, what stands against it, and what to do next.

    Parameters
    ----------
    verdicts : mapping of str to Verdict
        By axis; under an empty name where there is one for all.
    """
    chosen = [
        " ".join(filter(None, (name and f"{name}:", v.recommended, _chance(v))))
        for name, v in verdicts.items()
    ]
    against: dict[str, list[str]] = {}
    for name, verdict in verdicts.items():
        open_ = [verdict.not_excluded] if verdict.not_excluded else []
        for why in verdict.withheld or (*open_, *_limits(verdict)):
            against.setdefault(why, []).append(name)
    reasons = [why + _of(names, len(verdicts)) for why, names in against.items()]
    findings = ordered(f for v in verdicts.values() for f in v.findings)
    step = next_step(findings) or ("read the caveats" if findings else "")
    lines = (
        f"Recommended: {'; '.join(chosen)}.",
        f"Against it: {'; '.join(reasons) or 'nothing that was looked for'}.",
        f"Next: {step or ('more or better points' if reasons else ENOUGH)}.",
    )
    return Part("Remember", (Listing(lines),))


def _chance(verdict: Verdict) -> str:
    if verdict.compared == 1:
        return "(the only one compared)"
    return f"({percent(verdict.chances[0])})" if verdict.chances else ""


def _limits(verdict: Verdict) -> tuple[str, ...]:
    """Name what limits the verdict, where nothing withholds it."""
    kinds = dict.fromkeys(f.kind.split(": ")[-1] for f in verdict.findings)
    return (f"caveats on {', '.join(kinds)}",) if kinds else ()


def _of(names: list[str], every: int) -> str:
    """Name the axes that a reason is of, where it is not of all."""
    return f" ({', '.join(names)})" if len(names) < every else ""
