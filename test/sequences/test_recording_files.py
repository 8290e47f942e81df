import pytest

from cable_tracker.sequences.recording_files import recording_files


@pytest.fixture
def sequence(tmp_path):
    """Lists two pictures, the second of which is missing."""
    (tmp_path / "a.png").touch()
    path = tmp_path / "dive.txt"
    path.write_text("1 0 30 0 # a.png\n2 0 30 0 # b.png\n3 0 30 0 # a.png\n")
    return path


def test_a_sequence_file_is_read_from_the_pictures_that_it_names(sequence):
    assert recording_files(sequence) == [sequence, sequence.parent / "a.png"]


def test_a_malformed_sequence_file_names_nothing(sequence):
    sequence.write_text("1 0 # a.png\n")
    assert recording_files(sequence) == [sequence]


def test_a_bag_is_its_folder_also_by_its_metadata(tmp_path):
    assert recording_files(tmp_path) == [tmp_path]
    assert recording_files(tmp_path / "metadata.yaml") == [tmp_path]
