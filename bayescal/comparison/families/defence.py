"""What a referee asks of a verdict across families: what if a point or a group were not there.

Bootstrap and other noise would sample every model again and are left out: `LEFT_OUT` says so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from bayescal.arrays import Array
from bayescal.comparison.defence.argument import removal_words
from bayescal.comparison.defence.stability import Removal, removals
from bayescal.comparison.families.candidates.joint import Gaussian
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyDefence
from bayescal.comparison.key import Key
from bayescal.comparison.store import Store
from bayescal.points.correspondences import Correspondences
from bayescal.points.groups import groups_of

# Models that may win without a point or a group: the most probable ones.
RIVALS = 6
# Groups beyond which taking each out in turn takes minutes.
MOST_GROUPS = 60
LEFT_OUT = (
    "Not done for joint models, which would all be sampled again: bootstrap, and "
    "other noise (--noise student-t compares under it)."
)


def defend(
    points: Correspondences,
    models: Sequence[JointModel],
    candidates: Mapping[Key, Gaussian],
    store: Store,
) -> FamilyDefence:
    """Take out points and groups in turn; the most probable model is the first.

    Points by leave-one-out of the models that have it, groups by the evidence of the others, in
    closed form or by Laplace's approximation.
    """
    rivals, best = models[:RIVALS], models[0].key
    known = [m for m in rivals if m.loo is not None and m.loo.reliable]
    by_point = {m.key: m.log_evidence - m.loo.pointwise for m in known if m.loo is not None}
    single: tuple[Removal, ...] = ()
    if best in by_point and len(by_point) > 1:
        single = removals(points.labels, [1] * len(points), by_point, best)
    groups = groups_of(points)
    if groups is None or len(groups.names) > MOST_GROUPS or len(rivals) < 2:
        return FamilyDefence(single, (), None, 0)
    sizes = groups.members.sum(axis=1).astype(int).tolist()
    by_group = {
        m.key: store.once_of(m.key)(
            "without groups", Array, partial(candidates[m.key].without_groups, groups.members)
        )
        for m in rivals
    }
    found = removals(groups.names, sizes, by_group, best)
    return FamilyDefence(single, found, groups.source, len(groups.names))


def defence_words(found: FamilyDefence) -> str:
    """Say whose removal would change the most probable model."""
    return removal_words(
        found.points_that_matter, found.groups_that_matter, grouped=found.groups > 0
    )
