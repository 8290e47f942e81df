import pytest

from cable_tracker.errors import OutputError
from cable_tracker.visualisation.files import write_bytes


def test_the_content_is_written_and_nothing_else(tmp_path):
    write_bytes(tmp_path / "a.bin", b"abc")
    assert (tmp_path / "a.bin").read_bytes() == b"abc"
    assert len(list(tmp_path.iterdir())) == 1


def test_an_existing_file_is_replaced(tmp_path):
    (tmp_path / "a.bin").write_bytes(b"a longer content")
    write_bytes(tmp_path / "a.bin", b"abc")
    assert (tmp_path / "a.bin").read_bytes() == b"abc"


def test_a_missing_folder_is_reported(tmp_path):
    with pytest.raises(OutputError, match=r"a\.bin: cannot be written") as caught:
        write_bytes(tmp_path / "missing" / "a.bin", b"abc")
    assert "\n" not in str(caught.value)


def test_a_file_instead_of_a_folder_is_reported(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(OutputError, match=r"a\.bin: cannot be written"):
        write_bytes(tmp_path / "file" / "a.bin", b"abc")


def test_a_folder_in_its_place_is_reported_and_nothing_left(tmp_path):
    (tmp_path / "a.bin").mkdir()
    with pytest.raises(OutputError, match=r"a\.bin: cannot be written"):
        write_bytes(tmp_path / "a.bin", b"abc")
    assert [path.name for path in tmp_path.iterdir()] == ["a.bin"]
