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


@pytest.mark.parametrize("named", [".", "metadata.yaml"])
def test_a_bag_is_what_lies_in_its_folder_without_the_results_in_folders_within(tmp_path, named):
    files = [tmp_path / "dive.mcap", tmp_path / "metadata.yaml"]
    for file in files:
        file.touch()
    (tmp_path / "map" / "recordings").mkdir(parents=True)
    (tmp_path / "map" / "report.html").touch()
    assert recording_files(tmp_path / named) == files


def test_a_missing_recording_is_its_own_file(tmp_path):
    assert recording_files(tmp_path / "dive") == [tmp_path / "dive"]
