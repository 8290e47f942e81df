from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path

import dask
import pytest
from campaign_tasks import (
    Erring,
    Failing,
    KillsItsWorkerOnce,
    Square,
    SquareResult,
    Unreachable,
    become_another_version,
    done_elsewhere,
)
from distributed import Client, LocalCluster
from distributed.scheduler import KilledWorker

from cable_tracker.atomic_output import output_file
from cable_tracker.campaigns.cluster import (
    KEPT_MEMORY,
    _check_memory,
    _Progress,
    _readable_error,
    connected,
    worker_environment,
)
from cable_tracker.campaigns.folder_tasks import TaskState
from cable_tracker.campaigns.runner import run_all, run_folder_tasks
from cable_tracker.campaigns.settings import (
    CampaignSettings,
    ClusterSettings,
)
from cable_tracker.errors import (
    ParameterError,
    RecordingError,
)

pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("default")

pytest.importorskip("distributed")

HERE = Path(__file__).parent
ALONE = ClusterSettings()


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


@pytest.fixture(scope="module")
def cluster():
    """Two worker processes that know the tasks of these tests."""
    before = os.environ.get("PYTHONPATH", "")
    os.environ["PYTHONPATH"] = f"{HERE}{os.pathsep}{before}"
    try:
        with LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None,
            silence_logs=50,
        ) as running:  # fmt: skip
            yield running
    finally:
        os.environ["PYTHONPATH"] = before


@pytest.fixture
def mixed(monkeypatch):
    """Two worker processes, one of them of another version, which came after a campaign began."""
    monkeypatch.setenv("PYTHONPATH", f"{HERE}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.setattr("cable_tracker.campaigns.cluster.check_versions", lambda _client: None)
    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None,
            silence_logs=50,
        ) as running,
        Client(running) as client,
    ):  # fmt: skip
        late = next(iter(client.run(os.getpid)))
        client.run(become_another_version, workers=[late])
        told = []
        yield (
            ClusterSettings(scheduler=running.scheduler_address, on_notice=told.append),
            late,
            told,
        )


@pytest.fixture
def both(cluster) -> ClusterSettings:
    return ClusterSettings(scheduler=cluster.scheduler_address)


def states(outcomes):
    return [outcome.state for outcome in outcomes]


def wait_until_idle(cluster):
    """Wait until no worker does anything: a task outlives the client that asked for it."""
    deadline = time.monotonic() + 600.0
    with Client(cluster) as client:
        while any(client.run(lambda dask_worker: dask_worker.state.executing_count).values()):
            assert time.monotonic() < deadline
            time.sleep(0.1)


def test_results_lie_on_the_disk_in_folders_of_their_own(both, tmp_path):
    outcomes = run_folder_tasks([Square(n) for n in range(6)], tmp_path, both)
    assert states(outcomes) == [TaskState.DONE] * 6
    assert [(tmp_path / f"number_{n}/square.txt").read_text() for n in range(6)] == [
        str(n * n) for n in range(6)
    ]


def test_what_fails_is_a_row_that_says_why(both, tmp_path):
    outcomes = run_folder_tasks([Square(1), Failing(2), Square(3)], tmp_path, both)
    assert states(outcomes) == [TaskState.DONE, TaskState.FAILED, TaskState.DONE]
    assert outcomes[1].reason == "number_2: holds no frames"
    assert not (tmp_path / "number_2").exists()


@pytest.mark.parametrize("where", [ALONE, "both"])
def test_an_error_that_is_not_foreseen_ends_no_other_task_either(request, tmp_path, where):
    settings = request.getfixturevalue(where) if isinstance(where, str) else where
    outcomes = run_folder_tasks([Square(1), Erring(2), Square(3)], tmp_path, settings)
    assert states(outcomes) == [TaskState.DONE, TaskState.FAILED, TaskState.DONE]
    assert outcomes[1].reason == "ZeroDivisionError: division by zero"


class Stopped(Square):
    def run(self, folder, advance):
        raise KeyboardInterrupt


def test_an_earlier_result_stays_until_the_new_one_is_complete(tmp_path):
    run_folder_tasks([Square(1), Square(2)], tmp_path, ALONE)
    with pytest.raises(KeyboardInterrupt):
        run_folder_tasks([Stopped(1), Square(2, parameter="another")], tmp_path, ALONE)
    assert [(tmp_path / f"number_{n}/square.txt").read_text() for n in (1, 2)] == ["1", "4"]


@pytest.mark.parametrize("where", [ALONE, "both"])
@pytest.mark.parametrize("failing", [Failing, Erring, Unreachable])
def test_a_task_that_fails_now_leaves_its_earlier_result_and_says_so(
    request, tmp_path, where, failing
):
    settings = request.getfixturevalue(where) if isinstance(where, str) else where
    run_folder_tasks([Square(1)], tmp_path, ALONE)
    (outcome,) = run_folder_tasks([failing(1, parameter="mistyped")], tmp_path, settings)
    assert outcome.state is TaskState.FAILED
    assert outcome.reason.endswith(
        "; its earlier results stay in the folder number_1 and do not count here"
    )
    assert states(run_folder_tasks([Square(1)], tmp_path, ALONE, resume=True)) == [TaskState.KEPT]


def test_without_an_earlier_result_nothing_is_said_to_stay(tmp_path):
    (outcome,) = run_folder_tasks([Unreachable(3)], tmp_path, ALONE)
    assert outcome.reason.endswith("no such file")
    assert not list(tmp_path.iterdir())


def test_a_result_that_another_run_is_making_anew_stays(tmp_path):
    run_folder_tasks([Square(1)], tmp_path, ALONE)
    with output_file(tmp_path / "number_1", lambda _earlier: True, overwrite=True) as folder:
        folder.mkdir()
        (outcome,) = run_folder_tasks([Square(1, parameter="another")], tmp_path, ALONE)
        assert "another run is writing it" in outcome.reason
        assert (tmp_path / "number_1/square.txt").read_text() == "1"


def test_an_earlier_result_is_not_taken_for_that_of_a_worker_that_does_not_share_the_folder(
    both, tmp_path, monkeypatch
):
    run_folder_tasks([Square(1)], tmp_path, ALONE)
    monkeypatch.setattr("cable_tracker.campaigns.runner.run_in_folder", done_elsewhere)
    (outcome,) = run_folder_tasks([Square(1, parameter="another")], tmp_path, both)
    assert outcome.state is TaskState.FAILED
    assert "workers on other machines must share this folder" in outcome.reason


def test_tasks_of_a_killed_worker_are_done_by_others(both, tmp_path):
    traces = tmp_path / "traces"
    traces.mkdir()
    tasks = [Square(1), KillsItsWorkerOnce(2, traces=str(traces)), Square(3)]
    outcomes = run_folder_tasks(tasks, tmp_path / "results", both)
    assert states(outcomes) == [TaskState.DONE] * 3


def test_a_worker_that_was_ended_again_and_again_is_told_with_what_to_do():
    told = _readable_error(KilledWorker("task", None, 3))
    assert isinstance(told, ParameterError)
    assert "killed several times" in str(told) and "give more memory" in str(told)


@pytest.mark.parametrize("count", [60, pytest.param(200, marks=pytest.mark.slow)])
def test_many_tiny_tasks_all_come_to_their_end(both, tmp_path, count):
    counted = []
    tasks = [Square(n) for n in range(count)]
    outcomes = run_folder_tasks(tasks, tmp_path, both, advance=counted.append)
    assert states(outcomes) == [TaskState.DONE] * count


def test_the_end_of_a_task_in_the_midst_of_its_reports_counts_no_frame_twice():
    told = []
    progress = _Progress(told.append)
    ending = threading.Thread(target=progress.end, args=(0, 5))

    class Ended(set):
        def __contains__(self, number):
            is_in = super().__contains__(number)
            ending.start()
            # Where nothing keeps it waiting it is done before the report goes on.
            ending.join(1.0)
            return is_in

    progress._ended = Ended()
    progress.report(0, 2)
    ending.join()
    assert sum(told) == 5


def test_results_that_are_sent_back_come_in_order(both):
    assert run_all([SquareResult(n) for n in range(5)], CampaignSettings(both)) == [
        0,
        1,
        4,
        9,
        16,
    ]


def test_the_first_error_ends_tasks_whose_results_are_sent_back(both):
    with pytest.raises(RecordingError, match="a negative number"):
        run_all([SquareResult(1), SquareResult(-1)], CampaignSettings(both))


def test_resuming_does_only_what_is_missing_or_has_changed(tmp_path):
    run_folder_tasks([Square(1), Square(2)], tmp_path, ALONE)
    again = [Square(1), Square(2, parameter="another"), Square(3)]
    assert states(run_folder_tasks(again, tmp_path, ALONE, resume=True)) == [
        TaskState.KEPT, TaskState.DONE, TaskState.DONE,
    ]  # fmt: skip


def test_another_version_does_everything_again(tmp_path, monkeypatch):
    run_folder_tasks([Square(1)], tmp_path, ALONE)
    monkeypatch.setattr("cable_tracker.campaigns.runner.__version__", "999.0")
    assert states(run_folder_tasks([Square(1)], tmp_path, ALONE, resume=True)) == [TaskState.DONE]


def test_what_a_killed_client_left_is_kept(cluster, tmp_path):
    program = (
        "from pathlib import Path\n"
        "from campaign_tasks import Square, Waiting\n"
        "from cable_tracker.campaigns.settings import ClusterSettings\n"
        "from cable_tracker.campaigns.runner import run_folder_tasks\n"
        f"settings = ClusterSettings(scheduler={cluster.scheduler_address!r})\n"
        f"late = [Waiting(n, until={str(tmp_path / 'end')!r}) for n in (2, 3)]\n"
        "tasks = [Square(0), Square(1), *late]\n"
        f"run_folder_tasks(tasks, Path({str(tmp_path)!r}), settings)\n"
    )
    path = f"{HERE}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    client = subprocess.Popen(
        [sys.executable, "-c", program], env={**os.environ, "PYTHONPATH": path}
    )
    try:
        deadline = time.monotonic() + 600.0
        while not all((tmp_path / f"number_{n}/square.txt").exists() for n in range(2)):
            assert time.monotonic() < deadline and client.poll() is None
            time.sleep(0.1)
    finally:
        client.kill()
        client.wait()
        # What the workers were about ends, so that they leave the folders alone.
        (tmp_path / "end").touch()
    wait_until_idle(cluster)
    # The same tasks as before but for their waiting, which is no part of what they are.
    outcomes = run_folder_tasks([Square(n) for n in range(4)], tmp_path, ALONE, resume=True)
    assert states(outcomes) == [TaskState.KEPT] * 2 + [TaskState.DONE] * 2


def test_workers_of_another_version_are_refused_with_words(both, tmp_path, monkeypatch):
    monkeypatch.setattr("cable_tracker.campaigns.cluster.__version__", "999.0")
    with pytest.raises(ParameterError, match=r"this is cable_tracker 999\.0, but .* has .*install"):
        run_folder_tasks([Square(1), Square(2)], tmp_path, both)


def test_a_worker_of_another_version_that_comes_later_does_nothing(both, tmp_path, monkeypatch):
    # It comes after the check of those that are there at the beginning.
    monkeypatch.setattr("cable_tracker.campaigns.cluster.check_versions", lambda _client: None)
    monkeypatch.setattr("cable_tracker.campaigns.cluster.__version__", "999.0")
    outcomes = run_folder_tasks([Square(1), Square(2)], tmp_path, both)
    assert states(outcomes) == [TaskState.FAILED] * 2
    assert "install one version" in outcomes[0].reason


def test_a_worker_of_another_version_that_comes_later_takes_no_tasks_from_the_others(
    mixed, tmp_path
):
    settings, late, told = mixed
    outcomes = run_folder_tasks([Square(n) for n in range(12)], tmp_path, settings)
    assert states(outcomes) == [TaskState.DONE] * 12
    (note,) = told
    assert late in note and "0.0.9" in note and "retired" in note


def test_results_are_sent_back_by_the_others_too(mixed):
    results = run_all([SquareResult(n) for n in range(12)], CampaignSettings(mixed[0]))
    assert results == [n * n for n in range(12)]


def test_no_scheduler_is_said(tmp_path, monkeypatch):
    monkeypatch.setattr("cable_tracker.campaigns.cluster.CONNECT_TIMEOUT", 1.0)
    with pytest.raises(ParameterError, match=r"none answers at tcp://127\.0\.0\.1:9"):
        run_folder_tasks([Square(1)], tmp_path, ClusterSettings(scheduler="tcp://127.0.0.1:9"))


def test_two_recordings_of_one_name_are_refused(tmp_path):
    with pytest.raises(ParameterError, match="two recordings are called number_1"):
        run_folder_tasks([Square(1), Square(1)], tmp_path, ALONE)
