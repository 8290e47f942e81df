"""Open a bag of any kind, as its files allow: whole, unfinished, packed or damaged."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from weakref import finalize

import zstandard

from cable_tracker.errors import RecordingError, one_line
from cable_tracker.sequences.bags import mcap_recovery
from cable_tracker.sequences.bags.bag_limits import room_to_unpack, unpacked_blocks
from cable_tracker.sequences.bags.bag_storage import BagStorage
from cable_tracker.sequences.bags.rosbags_storage import RosbagsStorage
from cable_tracker.sequences.bags.salvaged_storage import SalvagedStorage
from cable_tracker.sequences.bags.storage_files import (
    METADATA,
    is_mcap,
    mcap_files,
    packed_files,
    storage_files,
)
from cable_tracker.sequences.natural_order import naturally_sorted

_NO_END = "it has no end (a crashed recorder or a cut-off copy); read as far as it goes"

MORE_THAN_ROS2 = (
    "it is not of ROS 2 alone, or does not say that it is; what is of ROS 2 is read, without the"
    " index, which takes longer"
)


def open_bag(path: Path) -> BagStorage:
    """Open a bag folder or a single .db3, .mcap or .bag file, and look what topics it holds.

    Raises
    ------
    RecordingError
        Not one message can be read.
    """
    try:
        is_ros1_mcap = any(mcap_recovery.profile_of(file) == "ros1" for file in mcap_files(path))
        if not is_ros1_mcap:
            return _open_storage(path)
    except (RecordingError, OSError) as error:
        raise RecordingError(
            f"{path}: not one message can be read ({one_line(error)}); check that the"
            " recording is a bag and was copied completely"
        ) from error
    raise RecordingError(
        f"{path}: holds ROS 1 messages, which are not read from mcap; give the .bag that it was"
        " made of, or convert it to a ROS 2 bag"
    )


def _open_storage(path: Path) -> BagStorage:
    """Open a bag in the way that its files allow.

    Raises
    ------
    RecordingError
        Not one message can be read. The message is the reason alone, without the path.
    """
    is_whole_bag = path.is_dir() and (path / METADATA).exists()
    if not is_whole_bag and packed_files(path):
        return _open_packed(path)
    if _crashed_files(path):
        storage: BagStorage = SalvagedStorage(storage_files(path), None)
        if not storage.topics:
            raise RecordingError("it breaks off before the first message")
        storage.note = _NO_END
        return storage
    if path.is_dir() and not (path / METADATA).exists():
        return _open_without_metadata(path)
    try:
        storage = RosbagsStorage(path)
    except Exception as error:
        damage = RecordingError(one_line(error))
        damage.__cause__ = error
        files = storage_files(path)
        if not files:
            raise damage from error
        if _is_more_than_ros2(path):
            # rosbags opens none of it, and nothing is damaged.
            storage = SalvagedStorage(files, None)
            storage.note = MORE_THAN_ROS2
            return storage
        return SalvagedStorage(files, damage)
    storage.note = _unmerged_log(path)
    return storage


def _crashed_files(path: Path) -> list[Path]:
    """Return the mcap files of a bag that were never closed."""
    return [
        file
        for file in mcap_files(path)
        if file.stat().st_size and not mcap_recovery.is_closed(file)
    ]


def _unmerged_log(path: Path) -> str:
    logs = [file.with_name(file.name + "-wal") for file in storage_files(path)]
    waiting = [log for log in logs if log.exists() and log.stat().st_size]
    if not waiting:
        return ""
    return (
        f"{waiting[0].name} holds messages of a recorder that did not end well; they are not read"
        " (merge them with: sqlite3 FILE.db3 'PRAGMA wal_checkpoint')"
    )


def _is_more_than_ros2(path: Path) -> bool:
    """Tell whether a bag is of mcap files that are not of ROS 2 alone, or do not say so."""
    files = mcap_files(path)
    try:
        is_whole = all(map(mcap_recovery.is_closed, files))
        return is_whole and not all(map(mcap_recovery.is_ros2_alone, files))
    except Exception:  # noqa: BLE001  Damage, of which its reader tells.
        return False


def _open_without_metadata(path: Path) -> BagStorage:
    files = storage_files(path)
    if len(files) == 1:
        return _open_storage(files[0])
    storage = SalvagedStorage(files, None)
    storage.note = _one_after_the_other(files)
    return storage


def _one_after_the_other(files: list[Path]) -> str:
    return f"{METADATA} is missing; {len(files)} files were read one after the other"


def _open_packed(path: Path) -> BagStorage:
    """Open compressed files without metadata, as a recorder that crashed leaves those it finished.

    They are read from copies, which go with the storage.
    """
    plain = storage_files(path) if path.is_dir() else []
    folder = TemporaryDirectory()
    try:
        copies, damage = _unpack(packed_files(path), Path(folder.name))
        files = naturally_sorted((*plain, *copies))
        storage = SalvagedStorage(files, damage)
    except BaseException:
        folder.cleanup()
        raise
    finalize(storage, folder.cleanup)
    if not all(mcap_recovery.is_closed(file) for file in files if is_mcap(file)):
        storage.note = _NO_END
    elif len(files) > 1:
        storage.note = _one_after_the_other(files)
    return storage


def _unpack(files: list[Path], folder: Path) -> tuple[list[Path], RecordingError | None]:
    """Unpack files into a folder, each as far as it goes; return the copies and the damage met."""
    copies: list[Path] = []
    damage: RecordingError | None = None
    room = room_to_unpack()
    for file in files:
        copies.append(folder / file.stem)
        with copies[-1].open("wb") as copy:
            try:
                copy.writelines(unpacked_blocks(file, room))
            except zstandard.ZstdError:
                damage = damage or RecordingError(f"{file.name} cannot be unpacked to its end")
            room -= copy.tell()
    return copies, damage
