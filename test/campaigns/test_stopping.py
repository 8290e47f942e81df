import pytest
from campaign_tasks import Square

from cable_tracker import __version__
from cable_tracker.atomic_output import any_name, output_folder
from cable_tracker.campaigns.folder_tasks import is_done
from cable_tracker.campaigns.result_store import stored_beside
from cable_tracker.campaigns.runner import run_all, run_folder_tasks
from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.campaigns.stopping import noting_finished_tasks
from cable_tracker.errors import OutputError, ParameterError


class Signal(BaseException):
    """Stops whatever is going on."""


class Stopping(Square):
    def run(self, folder, advance):
        raise Signal


class StoppingTask:
    def run(self, advance):
        raise Signal


class Three:
    def run(self, advance):
        return 3


def notes_of(stopped) -> str:
    return "; ".join(getattr(stopped.value, "__notes__", ()))


def test_who_stops_a_campaign_hears_what_is_kept(tmp_path):
    tasks = [Square(1), Square(2), Stopping(3), Square(4)]

    def finished():
        return sum(is_done(task, tmp_path / task.name, __version__) for task in tasks)

    with pytest.raises(Signal) as stopped, noting_finished_tasks(tmp_path, finished):
        run_folder_tasks(tasks, tmp_path, ClusterSettings())
    assert (
        notes_of(stopped) == f"2 finished tasks are kept in {tmp_path}; --resume goes on from there"
    )


def test_results_in_a_store_are_kept_too(tmp_path):
    output = tmp_path / "tables"
    with (
        pytest.raises(Signal) as stopped,
        stored_beside(output, ClusterSettings(), resume=False) as settings,
    ):
        run_all([Three(), StoppingTask()], settings)
    assert notes_of(stopped).startswith("1 finished task is kept in ")


def test_folders_in_a_store_are_kept_too(tmp_path):
    with (
        pytest.raises(Signal) as stopped,
        stored_beside(tmp_path / "loops", ClusterSettings(), resume=False) as settings,
    ):
        run_folder_tasks([Square(1), Stopping(2)], settings.store, ClusterSettings())
    assert notes_of(stopped).startswith("1 finished task is kept in ")


def test_without_a_finished_task_there_is_nothing_to_say(tmp_path):
    with pytest.raises(Signal) as stopped, noting_finished_tasks(tmp_path, lambda: 0):
        run_folder_tasks([Stopping(1)], tmp_path, ClusterSettings())
    assert not notes_of(stopped)


def test_who_meets_a_full_disk_hears_what_is_kept(tmp_path):
    with pytest.raises(OutputError) as stopped, noting_finished_tasks(tmp_path, lambda: 2):
        raise OutputError("No space left on device")
    assert notes_of(stopped).startswith("2 finished tasks are kept in ")


def test_what_is_kept_is_told_too_where_the_folder_of_results_finds_the_disk_full(tmp_path):
    with (
        pytest.raises(OutputError) as stopped,
        output_folder(tmp_path / "out", "report.html", overwrite=False, is_own_name=any_name),
        noting_finished_tasks(tmp_path, lambda: 2),
    ):
        raise OSError("No space left on device")
    assert notes_of(stopped).startswith("2 finished tasks are kept in ")


def test_a_full_disk_before_the_first_task_is_only_told(tmp_path):
    with pytest.raises(OutputError) as stopped, noting_finished_tasks(tmp_path, lambda: 0):
        raise OutputError("No space left on device")
    assert not notes_of(stopped)


def test_errors_speak_for_themselves(tmp_path):
    with pytest.raises(ParameterError) as stopped, noting_finished_tasks(tmp_path, lambda: 1):
        raise ParameterError("workers is 0")
    assert not notes_of(stopped)
