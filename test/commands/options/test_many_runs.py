import pytest

from cable_tracker.cable.parameters.presets import preset
from cable_tracker.campaigns.settings import LARGEST_WORKER_COUNT
from cable_tracker.commands.options.many_runs import (
    MEMORY,
    chosen_cluster,
    with_whole_paths,
)
from cable_tracker.errors import ParameterError


@pytest.mark.parametrize(
    ("processors", "workers"), [(None, 1), (8, 8), (384, LARGEST_WORKER_COUNT)]
)
def test_without_a_number_there_are_as_many_workers_as_processors_if_they_may_be_so_many(
    monkeypatch, processors, workers
):
    monkeypatch.setattr("os.cpu_count", lambda: processors)
    assert chosen_cluster(None, None, MEMORY, False).workers == workers


@pytest.mark.parametrize(("workers", "scheduler"), [(1, None), (4, "tcp://host:8786")])
def test_pages_that_would_not_be_served_are_refused(workers, scheduler):
    with pytest.raises(ParameterError, match="leave out --dashboard"):
        chosen_cluster(workers, scheduler, MEMORY, True)


def test_the_address_of_the_pages_is_printed_when_it_is_known(capsys):
    settings = chosen_cluster(2, None, MEMORY, True)
    assert capsys.readouterr().err == ""
    settings.on_dashboard("http://127.0.0.1:8787/status")
    assert capsys.readouterr().err == "Dask's pages: http://127.0.0.1:8787/status\n"


def test_workers_in_other_folders_get_absolute_paths(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    parameters = preset("default").replaced({"response_table": "mine/table.json"})
    assert with_whole_paths(parameters).response_table == str(tmp_path / "mine/table.json")
    assert with_whole_paths(preset("default")) == preset("default")
