"""emcee imported without what bayescal does not use of it.

Truth: what that is, for whoever else uses it in the same process, works.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.helpers.command import environment

SCRIPT = """
import sys
import bayescal.inference.chains.sampling
brought = [name for name in ("scipy.stats", "h5py") if name in sys.modules]
import emcee, numpy as np
rng = np.random.default_rng(0)
keep = emcee.backends.HDFBackend("chain.h5")
keep.reset(20, 2)
sampler = emcee.EnsembleSampler(
    20, 2, lambda x: -x @ x / 2, moves=emcee.moves.KDEMove(), backend=keep
)
sampler.run_mcmc(rng.normal(size=(20, 2)), 9)
print(brought, emcee.backends.HDFBackend("chain.h5").iteration)
"""


def test_the_rest_of_emcee_works_for_others(tmp_path: Path) -> None:
    found = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        cwd=tmp_path, env=environment(), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert found.stdout == "[] 9\n"
