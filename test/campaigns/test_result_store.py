from __future__ import annotations

import os
import pickle
from dataclasses import dataclass
from pathlib import Path

import pytest
from campaign_tasks import Square

from cable_tracker.atomic_output import any_name
from cable_tracker.campaigns.folder_tasks import run_in_folder
from cable_tracker.campaigns.result_store import (
    STORE,
    campaign_folder,
    fingerprint_of,
    read_result,
    stored_beside,
    write_result,
)
from cable_tracker.campaigns.runner import run_all
from cable_tracker.campaigns.settings import CampaignSettings, ClusterSettings
from cable_tracker.errors import OutputError
from cable_tracker.tracking.status import TrackingStatus


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
