import pytest

from cable_tracker.errors import OutputError
from cable_tracker.evaluation.folder import output_folder


def fill(path, text="1", overwrite=False):
    with output_folder(path, "mark", overwrite=overwrite) as folder:
        (folder / "mark").write_text(text)


def test_the_folder_appears_when_all_went_well(tmp_path):
    with output_folder(tmp_path / "out", "mark", overwrite=False) as folder:
        (folder / "mark").write_text("x")
        assert not (tmp_path / "out").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_nothing_is_left_after_a_failure(tmp_path):
    with pytest.raises(RuntimeError), output_folder(tmp_path / "out", "mark", overwrite=False):
        raise RuntimeError
    assert not any(tmp_path.iterdir())


def test_an_earlier_folder_is_replaced_only_when_told(tmp_path):
    fill(tmp_path / "out")
    with pytest.raises(OutputError, match="exists already"):
        fill(tmp_path / "out", "2")
    fill(tmp_path / "out", "2", overwrite=True)
    assert (tmp_path / "out" / "mark").read_text() == "2"


def test_a_folder_of_another_kind_is_never_replaced(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "photographs").write_text("dear")
    with pytest.raises(OutputError, match="is no earlier output of this kind"):
        fill(tmp_path / "out", overwrite=True)
    assert (tmp_path / "out" / "photographs").read_text() == "dear"
