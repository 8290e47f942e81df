"""The files of a bag, by their names."""

from __future__ import annotations

from pathlib import Path

from cable_tracker.sequences.natural_order import naturally_sorted

METADATA = "metadata.yaml"
"""File in the folder of a ROS 2 bag that says which storage files belong to it."""

ROS2_SUFFIXES = (".db3", ".mcap")
"""Suffixes of the storage files of a ROS 2 bag."""

PACKED_SUFFIX = ".zstd"
"""Follows that of a storage file which a recorder compressed as a whole."""

VEHICLE_FILE = "vehicle.yaml"
"""Beside the storage files of a bag it is read without being asked for, also where one of those is
named instead of the bag's folder."""

TRUTH_FILE = "truth.json"
"""Beside the storage file of a simulated survey."""

_ROS1_SUFFIX = ".bag"
BAG_SUFFIXES = (*ROS2_SUFFIXES, _ROS1_SUFFIX)


def is_ros1(path: Path) -> bool:
    """Tell whether a path names a ROS 1 bag; a folder may be called .bag and is none."""
    return path.suffix.lower() == _ROS1_SUFFIX and not path.is_dir()


def storage_files(path: Path) -> list[Path]:
    """Return the storage files of a bag folder in their natural order, or the file itself."""
    if not path.is_dir():
        return [path]
    return naturally_sorted(
        file for file in path.iterdir() if file.suffix.lower() in ROS2_SUFFIXES and file.is_file()
    )


def is_packed(path: Path) -> bool:
    """Tell whether a path names a storage file that a recorder compressed as a whole."""
    is_storage = Path(path.stem).suffix.lower() in ROS2_SUFFIXES
    return path.suffix.lower() == PACKED_SUFFIX and is_storage and path.is_file()


def packed_files(path: Path) -> list[Path]:
    """Return the compressed storage files of a folder, or the file itself if it is one.

    Beside the storage file that it is made of lies one that its recorder has not finished.
    """
    files = path.iterdir() if path.is_dir() else (path,)
    return [
        file
        for file in files
        if is_packed(file) and not (path.is_dir() and file.with_suffix("").exists())
    ]


def mcap_files(path: Path) -> list[Path]:
    """Return the mcap files among the storage files of a bag."""
    return [file for file in storage_files(path) if is_mcap(file)]


def is_mcap(file: Path) -> bool:
    """Tell whether a file is named as one of mcap."""
    return file.suffix.lower() == ".mcap"
