"""Which files a recording consists of."""

from __future__ import annotations

from pathlib import Path

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.storage_files import METADATA
from cable_tracker.sequences.labels.sequence_file import SEQUENCE_SUFFIXES, read_any_labels


def recording_files(path: Path) -> list[Path]:
    """Return the files that a recording is read from.

    Of a bag or a folder of pictures they are all files in the folder itself, but not what lies in
    folders within, such as results. Otherwise they are the path itself, and of an image-sequence
    file also the pictures and videos that it names; those that are missing are left out. Of
    `metadata.yaml` they are those of its bag.
    """
    folder = path.parent if path.name == METADATA else path
    if folder.is_dir():
        return sorted(file for file in folder.glob("*") if file.is_file())
    return [path, *(file for file in _named_files(path) if file.is_file())]


def _named_files(path: Path) -> list[Path]:
    if path.suffix.lower() not in SEQUENCE_SUFFIXES:
        return []
    try:
        labels = read_any_labels(path, allow_outside=True)
    except RecordingError:
        # What is wrong with it is said where it is opened.
        return []
    return [path.parent / name for name in dict.fromkeys(label.filename for label in labels)]
