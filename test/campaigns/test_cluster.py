from __future__ import annotations

import os
import urllib.request

import pytest

pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("default")

import dask  # noqa: E402

from cable_tracker.campaigns.cluster import (  # noqa: E402
    KEPT_MEMORY,
    _check_memory,
    connected,
    worker_environment,
)
from cable_tracker.campaigns.settings import ClusterSettings  # noqa: E402
from cable_tracker.errors import ParameterError  # noqa: E402


def test_workers_that_are_started_here_keep_freed_memory_and_serve_no_pages(monkeypatch):
    for name in KEPT_MEMORY:  # Dask leaves those of a cluster before in this process.
        monkeypatch.delenv(name, raising=False)
    told = []
    with connected(ClusterSettings(workers=1, on_dashboard=told.append)) as client:
        (found,) = client.run(lambda: dict(os.environ)).values()
    assert {name: int(found[name]) for name in KEPT_MEMORY} == KEPT_MEMORY
    # Pages that were not asked for are not served.
    assert told == []


def test_where_the_pages_are_is_told_while_they_are_served():
    told = []

    def fetch(address):
        with urllib.request.urlopen(address) as answer:
            told.append(answer.status)

    with connected(ClusterSettings(workers=1, dashboard=True, on_dashboard=fetch)):
        assert told == [200]


@pytest.mark.parametrize("memory", ["4", "10 MB", "255MiB", "-1GiB"])
def test_memory_in_which_no_worker_can_begin_is_refused(memory):
    with pytest.raises(ParameterError, match="too little"):
        _check_memory(memory.replace(" ", ""))
    with (
        pytest.raises(ParameterError, match="too little"),
        connected(ClusterSettings(workers=1, memory=memory)),
    ):
        pass


@pytest.mark.parametrize("memory", ["256MiB", "4GiB", "0.5", "1", "0", "auto"])
def test_sizes_shares_and_all_of_the_memory_are_taken(memory):
    _check_memory(memory)


def test_other_variables_of_dask_stay_as_they_are_set():
    with dask.config.set({"distributed.nanny.pre-spawn-environ": {"OMP_NUM_THREADS": 3}}):
        assert worker_environment() == {"OMP_NUM_THREADS": 3, **KEPT_MEMORY}
