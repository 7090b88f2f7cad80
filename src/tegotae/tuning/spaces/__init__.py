"""Search spaces, one file per algorithm."""

from tegotae.tuning.spaces import cma_es, open_es, pgpe, ppo, sac
from tegotae.tuning.spaces.base import Space

SPACES: dict[str, Space] = {
    "pgpe": pgpe.SPACE,
    "cma-es": cma_es.SPACE,
    "openai-es": open_es.SPACE,
    "sac": sac.SPACE,
    "ppo": ppo.SPACE,
}
"""The spaces by the name that `tegotae tune --algorithm` takes."""

__all__ = ["SPACES", "Space"]
