import shlex
import socket

import cv2
import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.commands.label import label
from cable_tracker.errors import GuiError, RecordingError

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED")

from cable_tracker.gui.labelling.labels import FrameLabel
from cable_tracker.gui.labelling.window import LabelServer

LINE = "1 0 40 0 # dive/000.png\n"


@pytest.fixture
def folder(tmp_path):

    path = tmp_path / "dive"
    path.mkdir()
    cv2.imwrite(str(path / "000.png"), np.zeros((24, 32), np.uint8))
    return path


def test_a_missing_recording_is_refused(tmp_path):
    with pytest.raises(RecordingError, match="there is no such file or folder"):
        label(tmp_path / "nowhere.avi")


@pytest.mark.parametrize("named", [True, False])
def test_an_unreadable_label_file_is_refused_by_line_and_left_alone(folder, tmp_path, named):
    labels = tmp_path / "dive.txt"
    labels.write_text(f"{LINE}what?\n")
    with pytest.raises(RecordingError, match=r"dive\.txt: line 2 is malformed"):
        label(folder, labels=labels if named else None)
    assert labels.read_text() == f"{LINE}what?\n"


def test_a_picture_that_cannot_be_decoded_is_a_frame_with_its_trouble(left_unsaved, folder):
    (folder / "001.png").write_bytes(b"no picture")
    seen = []

    def look(workspace):
        seen.append((workspace.count, workspace.picture(1).trouble))

    left_unsaved(folder, look)
    kinds = "neither JPEG, PNG, BMP, TIFF nor PNM"
    assert seen == [(2, f"the data is no picture: {kinds} by its first bytes")]


def test_a_taken_port_is_reported(folder):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(GuiError, match=f"port {port}"):
            label(folder, port=port)


@pytest.fixture
def left_unsaved(monkeypatch, capsys):
    """Label a recording, leave it unsaved, and return the closing note, on one line."""

    def left(source, meanwhile=lambda workspace: None, **options):
        def run(server, listening, started):
            workspace = server.workspace
            workspace.change(0, FrameLabel(CableState(1.0, 0.1, 20.0)))
            meanwhile(workspace)
            workspace.autosave()

        monkeypatch.setattr(LabelServer, "run", run)
        label(source, port=0, **options)
        return " ".join(capsys.readouterr().err.split())

    return left


def command_in(note):
    return shlex.split(note.split("`")[1])


def test_the_closing_note_names_the_command_that_offers_the_labels_again(left_unsaved, folder):
    source = folder.rename(folder.with_name("my dive #1"))
    note = left_unsaved(source)
    assert command_in(note) == ["cable-tracker", "label", str(source)]
    assert (folder.parent / "my dive #1.txt.autosave").exists()


def test_the_closing_note_names_options_without_which_other_labels_are_offered(
    left_unsaved, folder, tmp_path
):
    named = tmp_path / "second labels.txt"
    note = left_unsaved(folder, labels=named, rate=5.0, allow_outside=True)
    assert command_in(note)[2:] == [
        str(folder), "--rate", "5.0", "--allow-outside", "--labels", str(named),
    ]  # fmt: skip


def test_the_closing_note_names_the_file_that_was_chosen_in_the_page(
    left_unsaved, folder, tmp_path
):
    def save_elsewhere(workspace):
        workspace.save_as(tmp_path / "third.txt")
        workspace.change(0, None)

    note = left_unsaved(folder, save_elsewhere)
    assert command_in(note)[2:] == [str(folder), "--labels", str(tmp_path / "third.txt")]


def test_labels_that_could_not_be_saved_are_reported_as_lost(left_unsaved, folder, tmp_path):
    note = left_unsaved(folder, labels=tmp_path / "nowhere" / "labels.txt")
    assert note.startswith("note: the labels that were not saved are lost: ")
    assert "labels.txt.autosave (" in note
    assert "No such file or directory" in note
