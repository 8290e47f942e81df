from __future__ import annotations

import os
import pickle
from dataclasses import dataclass
from pathlib import Path

import pytest
from campaign_tasks import Square

from cable_tracker import __version__
from cable_tracker.atomic_output import any_name, output_folder
from cable_tracker.campaigns.folder_tasks import is_done, run_in_folder
from cable_tracker.campaigns.result_store import (
    STORE,
    campaign_folder,
    fingerprint_of,
    noting_finished_tasks,
    read_result,
    stored_beside,
    write_result,
)
from cable_tracker.campaigns.runner import run_all, run_folder_tasks
from cable_tracker.campaigns.settings import CampaignSettings, ClusterSettings
from cable_tracker.errors import OutputError, ParameterError
from cable_tracker.tracking.status import TrackingStatus


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


@dataclass(frozen=True)
class Counting:
    """Notes in a file that it was done."""

    number: int
    notes: Path

    def run(self, advance):
        with self.notes.open("a") as notes:
            notes.write(f"{self.number} ")
        advance(1)
        return self.number


def test_resuming_does_what_is_missing_or_has_changed(tmp_path):
    notes = tmp_path / "notes"
    settings = CampaignSettings(ClusterSettings(), tmp_path / "store", resume=True)
    for numbers in ((1, 2), (1, 2, 3)):
        assert run_all([Counting(n, notes) for n in numbers], settings) == list(numbers)
    assert notes.read_text() == "1 2 3 "


def test_without_resuming_everything_is_done_again(tmp_path):
    notes = tmp_path / "notes"
    for _ in range(2):
        settings = CampaignSettings(ClusterSettings(), tmp_path / "store")
        run_all([Counting(1, notes)], settings)
    assert notes.read_text() == "1 1 "


def test_a_kept_result_that_was_cut_off_is_done_again(tmp_path):
    notes, task = tmp_path / "notes", Counting(1, tmp_path / "notes")
    settings = CampaignSettings(ClusterSettings(), tmp_path / "store", resume=True)
    run_all([task], settings)
    kept = tmp_path / "store" / fingerprint_of(task)
    kept.write_bytes(kept.read_bytes()[:-2])
    assert run_all([task], settings) == [1]
    assert notes.read_text() == "1 1 "


def test_a_kept_result_runs_no_code(tmp_path):
    task, victim = Counting(1, tmp_path / "notes"), tmp_path / "victim"
    store = tmp_path / "store"
    store.mkdir()
    attack = pickle.dumps(Attack(victim))
    (store / fingerprint_of(task)).write_bytes(attack)
    assert run_all([task], CampaignSettings(ClusterSettings(), store, resume=True)) == [1]
    assert not victim.exists()


def test_a_kept_result_reaches_nothing_that_a_module_imports(tmp_path):
    task, victim = Counting(1, tmp_path / "notes"), tmp_path / "victim"
    store = tmp_path / "store"
    store.mkdir()
    module = "cable_tracker.ros.process.child_process"
    attack = (
        b"\x80\x04" + pickle_text(module) + pickle_text("subprocess.Popen") + b"\x93"
        b"]" + b"(" + pickle_text("touch") + pickle_text(str(victim)) + b"e\x85R."
    )
    (store / fingerprint_of(task)).write_bytes(attack)
    assert run_all([task], CampaignSettings(ClusterSettings(), store, resume=True)) == [1]
    assert not victim.exists()


def pickle_text(text):
    return pickle.BINUNICODE + len(text).to_bytes(4, "little") + text.encode()


def test_names_are_kept_however_python_writes_them(tmp_path, monkeypatch):
    by_name = lambda self, _protocol: (getattr, (type(self), self.name))  # noqa: E731
    monkeypatch.setattr(TrackingStatus, "__reduce_ex__", by_name)
    task = Counting(1, tmp_path / "notes")
    write_result(fingerprint_of(task), {"status": [TrackingStatus.LOST]}, tmp_path / "store")
    assert read_result(task, tmp_path / "store") == ({"status": [TrackingStatus.LOST]},)


def test_a_result_is_kept_for_its_own_task_only(tmp_path):
    first, second = (Counting(number, tmp_path / "notes") for number in (1, 2))
    write_result(fingerprint_of(first), {"frames": 3}, tmp_path / "store")
    assert read_result(first, tmp_path / "store") == ({"frames": 3},)
    assert read_result(second, tmp_path / "store") is None
    assert read_result(first, None) is None


def test_a_task_may_say_itself_what_stands_for_it(tmp_path):
    class Named(Counting):
        def fingerprint(self):
            return "always the same"

    assert fingerprint_of(Named(1, tmp_path)) == fingerprint_of(Named(2, tmp_path))
    assert fingerprint_of(Counting(1, tmp_path)) != fingerprint_of(Counting(2, tmp_path))


def test_a_task_may_speak_of_names_that_are_not_utf_8(tmp_path):
    one, other = (Path(os.fsdecode(name)) for name in (b"dive\xe4", b"dive\xf6"))

    class Naming(Counting):
        def fingerprint(self):
            return str(self.notes)

    assert fingerprint_of(Naming(1, one)) != fingerprint_of(Naming(1, other))


def test_a_result_that_cannot_be_written_is_reported(tmp_path):
    (tmp_path / "store").touch()
    with pytest.raises(OutputError, match="store: cannot be written"):
        write_result(fingerprint_of(Counting(1, tmp_path)), 1, tmp_path / "store")


def test_results_lie_beside_an_output_until_it_is_complete_and_in_it_then(tmp_path):
    output = tmp_path / "out"
    task = Counting(1, tmp_path / "notes")
    with campaign_folder(
        output, "table.md", ClusterSettings(), force=False, resume=False, is_own_name=any_name
    ) as (folder, settings):
        run_all([task], settings)
        (folder / "table.md").touch()
        assert (tmp_path / f"out.{STORE}").is_dir()
        assert not output.exists()
    assert (output / STORE / fingerprint_of(task)).is_file()
    with stored_beside(output, ClusterSettings(), resume=True) as settings:
        assert read_result(task, settings.store) == (1,)


def test_results_stay_beside_an_output_that_cannot_be_written(tmp_path, full_disk):
    task = Counting(1, tmp_path / "notes")
    with (
        pytest.raises(OutputError, match="No space left"),
        campaign_folder(
            tmp_path / "out", "table.md", ClusterSettings(),
            force=False, resume=False, is_own_name=any_name,
        ) as (_, settings),
    ):  # fmt: skip
        run_all([task], settings)
        full_disk()
    assert (tmp_path / f"out.{STORE}" / fingerprint_of(task)).is_file()
    assert not (tmp_path / "out").exists()


def test_what_an_earlier_campaign_has_left_is_removed(tmp_path):
    store = tmp_path / f"out.{STORE}"
    write_result(fingerprint_of(Counting(1, tmp_path / "notes")), 1, store)
    result = fingerprint_of(Counting(1, tmp_path / "notes"))
    (store / f".{result}.4711.part").write_bytes(b"half a res")
    (store / ".default_7.partial" / "default_7").mkdir(parents=True)
    run_in_folder(Square(3), store, "1.0", lambda count: None)
    with stored_beside(tmp_path / "out", ClusterSettings(), resume=False):
        assert not store.exists()


@pytest.mark.parametrize("name", ["thesis.tex", "photos/1.jpg", ".hidden"])
def test_a_folder_of_the_name_of_a_store_that_holds_anything_else_is_left_alone(tmp_path, name):
    store = tmp_path / f"out.{STORE}"
    write_result(fingerprint_of(Counting(1, tmp_path / "notes")), 1, store)
    (store / name).parent.mkdir(exist_ok=True)
    (store / name).write_text("my own")
    with (
        pytest.raises(OutputError, match=r"out\.tasks: is to be replaced, but holds .*; move it"),
        stored_beside(tmp_path / "out", ClusterSettings(), resume=False),
    ):
        pass
    assert (store / name).read_text() == "my own"
    assert read_result(Counting(1, tmp_path / "notes"), store) == (1,)


@dataclass(frozen=True)
class ReadingLabels(Counting):
    """Reads a file, into which other labels are saved while the task goes on."""

    def fingerprint(self):
        return self.notes.read_text()

    def run(self, advance):
        read = self.notes.read_text()
        self.notes.write_text("new labels")
        return read


def test_what_was_written_to_while_a_task_ran_is_done_again(tmp_path):
    task = ReadingLabels(1, tmp_path / "labels.txt")
    task.notes.write_text("old labels")
    settings = CampaignSettings(ClusterSettings(), tmp_path / "store", resume=True)
    assert run_all([task], settings) == ["old labels"]
    assert run_all([task], settings) == ["new labels"]
    assert run_all([task], settings) == ["new labels"]


class Attack:
    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)
