"""How the evidence depends on the prior and on the noise assumed."""

from __future__ import annotations

from bayescal.report.defence import tau_table
from bayescal.report.other_noises import noises_table, other_noise_lines
from bayescal.report.page.blocks import Block, Section, Tabled
from bayescal.report.page.subject import PageSubject


def section(subject: PageSubject) -> Section | None:
    """Show the evidence over fixed tau, and under other noise models."""
    parts: dict[str, tuple[Block, ...]] = {}
    for axis in subject.axes:
        defence, name = axis.defence, axis.data.axis
        if defence is None:
            continue
        blocks: list[Block] = []
        if defence.tau is not None:
            caption = (
                f"Log evidence of each order of {name} were the strength of the non-linearity, "
                "tau, known beforehand; a fraction of the image."
            )
            blocks.append(subject.picture("evidence", caption, name))
            blocks.append(
                Tabled(f"tau-{name}", "The same in numbers.", tau_table(axis, defence.tau))
            )
        if defence.noises:
            caption = f"Evidence of the recommended order of {name} under each noise model."
            table = noises_table(axis, defence.noises)
            lines = tuple(other_noise_lines(axis, defence.noises))
            blocks.append(Tabled(f"noises-{name}", caption, table, lines))
        parts[name] = tuple(blocks)
    if not any(parts.values()):
        return None
    return Section(
        "evidence",
        "Evidence and its assumptions",
        "Would another prior, or another noise, have chosen another order?",
        subject.parts(parts),
    )
