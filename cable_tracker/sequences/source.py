"""Open a recording of any kind as a source of frames."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError, RecordingError, UnreachableError, read_failure
from cable_tracker.sequences.bags.bag import BagSource, read_bag_truth
from cable_tracker.sequences.bags.storage_files import (
    BAG_SUFFIXES,
    METADATA,
    is_packed,
    is_ros1,
    packed_files,
    storage_files,
)
from cable_tracker.sequences.labels.frame_names import names_of
from cable_tracker.sequences.labels.sequence_file import (
    SEQUENCE_SUFFIXES,
    Label,
    SequenceFileSource,
    read_labels,
)
from cable_tracker.sequences.pictures.image_folder import ImageFolderSource, find_pictures
from cable_tracker.sequences.source_base import ChosenRecording, Source
from cable_tracker.sequences.videos.video import VIDEO_SUFFIXES, VideoSource


def is_bag(path: Path) -> bool:
    """Tell whether a path is that of a bag: by its suffix, or by what its folder holds."""
    if not path.is_dir():
        return path.suffix.lower() in BAG_SUFFIXES or is_packed(path)
    if (path / METADATA).exists():
        return True
    return bool(storage_files(path) or packed_files(path)) and not find_pictures(path)


def open_source(
    path: Path,
    *,
    topic: str | None = None,
    rate: float | None = None,
    truth: Path | None = None,
    skip_bad_frames: bool = False,
    allow_outside: bool = False,
    with_truth: bool = True,
) -> Source:
    """Open a recording; what lies at the path decides its kind.

    ======================================================  =======================
    path                                                    kind
    ======================================================  =======================
    folder with metadata.yaml, or with .db3 or .mcap alone  ROS 2 bag
    .db3, .mcap, .db3.zstd, .mcap.zstd                      one file of a ROS 2 bag
    .bag                                                    ROS 1 bag
    .mp4, .avi, .mkv, .mov, .webm, .mpg, .m4v, .ts          video
    folder with pictures                                    pictures by name
    .txt, .seq                                              image-sequence file
    ======================================================  =======================

    Parameters
    ----------
    path : Path
        Path of the recording.
    topic : str or None
        Image topic of a bag; None if it has just one.
    rate : float or None
        Frames per second of pictures, which have no time of their own; 25 if None.
    truth : Path or None
        Bag with `ground_truth`, whose labels are attached to the frames of a bag by time and to
        others by order; or sequence file whose labels are attached to the frames by number, or by
        file name for pictures. They take the place of all truth that the recording holds: only
        frames that they label then have one.
    skip_bad_frames : bool
        Hand out frames that cannot be decoded, instead of raising RecordingError.
    allow_outside : bool
        Whether a sequence file may name pictures and videos outside its folder.
    with_truth : bool
        Whether to read the truth that a bag holds itself, which takes a way through all of it.

    Raises
    ------
    RecordingError
        The recording or the labels are missing, empty, damaged, or of no known kind; or a label
        belongs to no frame, or a second one to the same frame.
    ParameterError
        The rate is not a positive number.
    """
    return open_chosen(
        ChosenRecording(
            path, topic, rate, truth, skip_bad_frames, allow_outside, with_truth=with_truth
        )
    )


def open_chosen(chosen: ChosenRecording) -> Source:
    """Open a recording; see `open_source`."""
    rate, path, truth = chosen.rate, chosen.path, chosen.truth
    if rate is not None and not (math.isfinite(rate) and rate > 0.0):
        raise ParameterError(f"rate must be a positive number of frames per second, not {rate}")
    try:
        if not path.exists():
            raise UnreachableError(f"{path}: there is no such file or folder; check the path")
        folder = path.parent if path.name == METADATA else path
        source = _open_unlabelled(replace(chosen, path=folder))
    except OSError as error:
        raise read_failure(path, error) from error
    if truth is not None and is_bag(truth):
        _label_from_bag(source, truth)
    elif truth is not None:
        source.label(_labels_by_frame(source, truth, chosen.allow_outside))
    return source


def _open_unlabelled(chosen: ChosenRecording) -> Source:
    path = chosen.path
    if path.is_file() and not path.stat().st_size:
        raise RecordingError(f"{path}: the file is empty; record or copy it again")
    if is_bag(path):
        return BagSource(chosen)
    if chosen.topic is not None:
        raise RecordingError(
            f"{path}: is no bag and has no topics; leave out --topic (node: topic)"
        )
    return _folder_source(chosen) if path.is_dir() else _file_source(chosen)


def _folder_source(chosen: ChosenRecording) -> Source:
    path = chosen.path
    if not any(path.iterdir()):
        # As the place of a disk looks that is not mounted.
        raise UnreachableError(
            f"{path}: the folder is empty: no pictures and no bag; is its disk mounted?"
        )
    bags = sorted(file.name for file in path.iterdir() if is_ros1(file))
    if bags and not find_pictures(path):
        raise RecordingError(f"{path}: is a folder with ROS 1 bags; name the file: {bags[0]}")
    return ImageFolderSource(chosen)


def _file_source(chosen: ChosenRecording) -> Source:
    path, suffix = chosen.path, chosen.path.suffix.lower()
    if suffix in VIDEO_SUFFIXES:
        return VideoSource(chosen)
    if suffix in SEQUENCE_SUFFIXES:
        return SequenceFileSource(chosen)
    known = (*BAG_SUFFIXES, *VIDEO_SUFFIXES, *SEQUENCE_SUFFIXES)
    raise RecordingError(
        f"{path}: {suffix or 'a file without suffix'} is no known kind of recording; known are"
        f" {', '.join(known)}, bag folders and folders of pictures"
    )


def _label_from_bag(source: Source, truth: Path) -> None:
    """Attach the ground truth of a bag: by time to a bag, by order to what has no time."""
    labels = read_bag_truth(truth)
    if isinstance(source, BagSource):
        if labels and not source.has_frame_at(labels):
            raise RecordingError(
                f"{truth}: not one of its {len(labels)} labels has the time of a frame of"
                f" {source.path}; give the truth that belongs to this recording"
            )
        source.label_by_stamp(labels)
        return
    if len(labels) != source.frame_count:
        count = source.frame_count or "an unknown number of"
        raise RecordingError(
            f"{truth}: holds {len(labels)} labels for {count} frames of {source.path},"
            f" which have no time to tell them apart; give a sequence file"
        )
    source.label({index: labels[stamp] for index, stamp in enumerate(sorted(labels))})


def _labels_by_frame(source: Source, truth: Path, allow_outside: bool) -> dict[int, CableState]:
    """Return the label of each labelled frame of a source, by the frame's number.

    Labels that are all of one file of another name are taken to be of this source.

    Raises
    ------
    RecordingError
        The labels cannot be read, a label belongs to no frame, or a second one to the same frame;
        the message names the line.
    """
    labels = read_labels(truth, allow_outside=allow_outside)
    names, count = names_of(source), source.frame_count
    frames = names.own_frames(labels, truth)
    files = {label.filename for label in labels}
    if not frames and len(files) == 1 and not any(map(names.lists, files)):
        frames = {str(label): label.frame for label in labels}
    names.need_any(frames.values(), truth)
    found: dict[int, Label] = {}
    for label in labels:
        if str(label) not in frames:
            continue
        number = frames[str(label)]
        if number is None:
            reason = f", which is no {names.what}"
        elif count is not None and number >= count:
            reason = f", but {source.path} has only {count} frames, counted from 0"
        elif number in found:
            reason = f" again, after line {found[number].line}; remove one of them"
        else:
            found[number] = label
            continue
        raise RecordingError(f"{truth}: line {label.line} labels {label}{reason}")
    return {number: label.state for number, label in found.items()}
