import pytest

from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.errors import ParameterError


@pytest.mark.parametrize("workers", [0, -1, 257])
def test_a_number_of_workers_out_of_range_is_refused(workers):
    with pytest.raises(ParameterError, match=f"workers is {workers}"):
        ClusterSettings(workers)


@pytest.mark.parametrize(
    ("settings", "count", "here"),
    [
        (ClusterSettings(1), 9, True),
        (ClusterSettings(4), 1, True),
        (ClusterSettings(4), 2, False),
        (ClusterSettings(1, scheduler="tcp://host:8786"), 1, False),
    ],
)
def test_one_worker_or_one_task_needs_no_cluster(settings, count, here):
    assert settings.is_here(count) is here
