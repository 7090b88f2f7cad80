"""The same study on a Dask cluster: of this machine, or of many."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tegotae.errors import TegotaeError
from tegotae.extras import require
from tegotae.study.record import Record
from tegotae.study.runner import Results, work_all
from tegotae.study.unit import Unit

_RETRIES = 5
_TIMEOUT_S = 20


def on_cluster(address: str) -> Results:
    """Do bundles on the Dask workers of the scheduler at `address`; `local` starts some here.

    Workers should have one thread each. They are told to use one core, so that every unit's
    numbers are those of a run without Dask. A bundle whose worker dies goes to another.

    Raises:
        TegotaeError: if `distributed` is not installed or the scheduler cannot be reached.
    """
    distributed = require("distributed", "cluster")
    try:
        if address == "local":
            client = distributed.Client(
                threads_per_worker=1, processes=True, dashboard_address=None
            )
        else:
            client = distributed.Client(address, timeout=_TIMEOUT_S)
    except (OSError, TimeoutError, ValueError) as error:
        why = (str(error).splitlines() or [type(error).__name__])[0]
        raise TegotaeError(f"no Dask scheduler can be reached at {address}: {why}") from None
    environment = require("distributed.diagnostics.plugin", "cluster").Environ
    client.register_plugin(environment({"TEGOTAE_CORES": "1"}))

    def results(work_to_do: Sequence[list[Unit]]) -> Iterator[tuple[Unit, Record]]:
        with client:
            futures = {
                client.submit(work_all, bundle, retries=_RETRIES, pure=False): bundle
                for bundle in work_to_do
            }
            for future in distributed.as_completed(futures):
                yield from zip(futures[future], future.result(), strict=True)

    return results
