"""What is fuzzed: functions that take any bytes and may raise nothing but our own errors."""

from __future__ import annotations

import os
import sqlite3
import struct
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from pathlib import Path
from types import MappingProxyType

import av
import cv2
import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from cable_tracker.cable.model.initial_state_text import parse_initial_state
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.errors import FrameError, ParameterError, RecordingError
from cable_tracker.followed_kinds import CABLE
from cable_tracker.sequences.bags.video_stream import (
    DECODERS,
    DecodedPicture,
    Packet,
    StreamDecoder,
)
from cable_tracker.sequences.encodings import ENCODINGS, decode_bgr, decode_grey
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.sequences.labels.sequence_file import Label, read_labels, write_labels
from cable_tracker.sequences.pictures.image_folder import load_picture
from cable_tracker.sequences.source import open_source
from cable_tracker.target.model.start import TargetStart, parse_start_text
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.parameter_files import (
    format_parameter_file,
    read_parameter_file,
)

MOST_FRAMES = 20
"""Frames that are read of a damaged recording."""

VIDEO_SIZE = (64, 48)
VIDEO_FRAMES = 3
CODINGS = (*sorted(DECODERS), "unknown")

STAMP = 1_700_000_000_000_000_000
STORES = {1: get_typestore(Stores.ROS1_NOETIC), 2: get_typestore(Stores.ROS2_JAZZY)}
RAW_FIELDS = struct.Struct("<BHHHB")


@dataclass(frozen=True, slots=True)
class Target:
    """Something to feed with bytes.

    Attributes
    ----------
    run : callable
        Takes the bytes; raises where a promise is broken.
    seeds : callable
        Returns inputs to begin with, by name.
    """

    run: Callable[[bytes], None]
    seeds: Callable[[], dict[str, bytes]]


def scratch() -> Path:
    """Return the folder of this process for files, in memory where there is such a place."""
    memory = Path("/dev/shm")
    parent = memory if os.access(memory, os.W_OK) else Path(tempfile.gettempdir())
    folder = parent / f"cable_tracker_fuzz_{os.getpid()}"
    folder.mkdir(exist_ok=True)
    return folder


@contextmanager
def as_file(data: bytes, name: str) -> Iterator[Path]:
    """Give the bytes as a file."""
    path = scratch() / name
    path.write_bytes(data)
    try:
        yield path
    finally:
        path.unlink()
        with suppress(OSError):
            path.parent.rmdir()


def check_grey(grey: np.ndarray) -> None:
    """Raise where a decoded picture is not what `decode_grey` promises."""
    assert grey.ndim == 2
    assert grey.size
    assert grey.dtype in (np.uint8, np.float32)
    if grey.dtype == np.float32:
        assert np.isfinite(grey).all()
        assert grey.min() >= 0.0
        assert grey.max() <= 255.0


def check_bgr(picture: np.ndarray) -> None:
    """Raise where a decoded picture is not what `decode_bgr` promises."""
    assert picture.ndim == 3
    assert picture.shape[2] == 3
    assert picture.dtype == np.uint8


def decode(image: RawImage | CompressedImage) -> None:
    """Decode in both ways; each may refuse."""
    with suppress(FrameError):
        check_grey(decode_grey(image))
    with suppress(FrameError):
        check_bgr(decode_bgr(image))


def run_picture(data: bytes) -> None:
    """JPEG, PNG and the other kinds of picture files."""
    decode(CompressedImage("jpeg", memoryview(data)))
    with as_file(data, "picture.png") as path, suppress(FrameError):
        decode(load_picture(path))


def picture_seeds() -> dict[str, bytes]:
    """Return one small picture of each kind."""
    grey = np.random.default_rng(1).integers(0, 256, (6, 8), dtype=np.uint8)
    suffixes = ("jpg", "png", "bmp", "tif", "pgm")
    seeds = {suffix: cv2.imencode(f".{suffix}", grey)[1].tobytes() for suffix in suffixes}
    colour = cv2.imencode(".png", np.dstack((grey, grey, grey, grey)).astype(np.uint16))
    return {**seeds, "deep": colour[1].tobytes()}


def run_raw_image(data: bytes) -> None:
    """Fields of a sensor_msgs/Image that need not fit together."""
    if len(data) < RAW_FIELDS.size:
        return
    choice, height, width, step, bigendian = RAW_FIELDS.unpack_from(data)
    encoding = ENCODINGS[choice] if choice < len(ENCODINGS) else f"mono{choice}"
    pixels = memoryview(data)[RAW_FIELDS.size :]
    decode(RawImage(encoding, height, width, step, bool(bigendian & 1), pixels))


def raw_image_seeds() -> dict[str, bytes]:
    """Return one image of each encoding, in 4 x 4 pixels of up to eight bytes."""
    return {
        name: RAW_FIELDS.pack(number, 4, 4, 32, number) + bytes(range(128))
        for number, name in enumerate(ENCODINGS)
    }


def run_sequence_file(data: bytes) -> None:
    """A sequence file: what is read can be written, and no name leads outside."""
    with as_file(data, "sequence.txt") as path:
        try:
            labels = read_labels(path)
        except RecordingError:
            return
        folder = path.parent.resolve()
        for label in labels:
            assert label.state.is_finite()
            assert Path(os.path.normpath(folder / label.filename)).is_relative_to(folder)
        if all(str(label).isprintable() for label in labels):
            again = path.with_name("again.txt")
            try:
                write_labels(again, labels)
                assert read_labels(again) == labels
            finally:
                again.unlink(missing_ok=True)


def sequence_file_seeds() -> dict[str, bytes]:
    """Return a sequence file of pictures and of a video."""
    states = [CableState(1.5, 0.1, 30.0, -0.01), CableState(-7.25, 1.5, 4.0)]
    labels = [
        Label("frame 1.png", state=states[0]),
        Label("deep/dive.mp4", 12, state=states[1]),
    ]
    with as_file(b"", "seed.txt") as path:
        write_labels(path, labels)
        written = path.read_bytes()
    return {"written": written, "outside": b"1 2 3 0.4 # ../../etc/passwd\n"}


def read_recording(path: Path) -> None:
    """Read a recording as a user does who goes on after bad frames."""
    with suppress(RecordingError), open_source(path, skip_bad_frames=True) as source:
        for frame in islice(source.frames(), MOST_FRAMES):
            decode(frame.image)


def run_file(name: str) -> Callable[[bytes], None]:
    """Return a target for recordings in one file."""

    def run(data: bytes) -> None:
        with as_file(data, name) as path:
            read_recording(path)

    return run


def encoded_packets(context: av.VideoCodecContext | av.VideoStream) -> Iterator[av.Packet]:
    """Encode a square that moves."""
    width, height = VIDEO_SIZE
    for number in range(VIDEO_FRAMES):
        picture = np.full((height, width, 3), 90, np.uint8)
        picture[10:30, 8 * number : 8 * number + 20] = 220
        yield from context.encode(av.VideoFrame.from_ndarray(picture, format="bgr24"))
    yield from context.encode(None)


def video_file(container: str, codec: str) -> bytes:
    """Return a video of three frames."""
    with as_file(b"", f"seed.{container}") as path:
        with av.open(str(path), "w") as video:
            stream = video.add_stream(codec, rate=25)
            stream.width, stream.height = VIDEO_SIZE
            stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
            for packet in encoded_packets(stream):
                video.mux(packet)
        return path.read_bytes()


def video_seeds() -> dict[str, bytes]:
    """Return videos of three containers and codings."""
    return {
        "mp4": video_file("mp4", "mpeg4"),
        "avi": video_file("avi", "mjpeg"),
        "webm": video_file("webm", "libvpx"),
    }


def run_video_stream(data: bytes) -> None:
    """Packets of a video stream: coding, then length (2 bytes) and bytes of each."""
    decoder = StreamDecoder()
    coding = CODINGS[data[0] % len(CODINGS)] if data else ""
    place = 1
    for number in range(MOST_FRAMES):
        if place + 2 > len(data):
            break
        length = int.from_bytes(data[place : place + 2], "little")
        unit = data[place + 2 : place + 2 + length]
        place += 2 + length
        check_pictures(decoder.take(Packet(STAMP + number, "eye", coding, unit, STAMP + number)))
    check_pictures(decoder.end())


def check_pictures(decoded: Iterable[DecodedPicture]) -> None:
    """Each packet has a picture, or a reason why there is none."""
    for each in decoded:
        assert (each.picture is None) == bool(each.reason)


def video_stream_seeds() -> dict[str, bytes]:
    """Return streams of two codings."""
    seeds = {}
    for coding, encoder in (("h264", "libx264"), ("vp9", "libvpx-vp9")):
        context = av.CodecContext.create(encoder, "w")
        assert isinstance(context, av.VideoCodecContext)
        context.width, context.height = VIDEO_SIZE
        context.pix_fmt, context.time_base = "yuv420p", Fraction(1, 25)
        units = [bytes(packet) for packet in encoded_packets(context)]
        parts = [len(unit).to_bytes(2, "little") + unit for unit in units]
        seeds[coding] = bytes([CODINGS.index(coding)]) + b"".join(parts)
    return seeds


def make_message(ros: int, number: int) -> object:
    """Return an image of 8 x 6 pixels."""
    types = STORES[ros].types
    sec, nanosec = divmod(STAMP + number * 40_000_000, 1_000_000_000)
    time = types["builtin_interfaces/msg/Time"](sec=sec, nanosec=nanosec)
    extra = {"seq": 0} if ros == 1 else {}
    header = types["std_msgs/msg/Header"](stamp=time, frame_id="eye", **extra)
    pixels = np.arange(48, dtype=np.uint8)
    return types["sensor_msgs/msg/Image"](header, 6, 8, "mono8", 0, 8, pixels)


def fill(writer: Writer | Writer1, ros: int) -> None:
    """Write three images."""
    store = STORES[ros]
    connection = writer.add_connection("/image", "sensor_msgs/msg/Image", typestore=store)
    serialise = store.serialize_ros1 if ros == 1 else store.serialize_cdr
    for number in range(3):
        data = serialise(make_message(ros, number), "sensor_msgs/msg/Image")
        writer.write(connection, STAMP + number * 40_000_000, data)


def bag_files(storage: str) -> dict[str, bytes]:
    """Return the files of a small ROS 2 bag by name."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bag"
        with Writer(path, version=9, storage_plugin=StoragePlugin[storage.upper()]) as writer:
            fill(writer, 2)
        return {file.name: file.read_bytes() for file in path.iterdir()}


def plain_mcap(compression: CompressionType | None) -> bytes:
    """Return an mcap without checksums, whose messages a fuzzer can change."""
    with as_file(b"", "seed.mcap") as path:
        writer = McapWriter(
            str(path),
            compression=compression or CompressionType.NONE,
            use_chunking=compression is not None,
            enable_crcs=False,
        )
        writer.start("ros2")
        schema = writer.register_schema("sensor_msgs/msg/Image", "ros2msg", b"uint8[] data")
        channel = writer.register_channel("/image", "cdr", schema)
        for number in range(3):
            data = STORES[2].serialize_cdr(make_message(2, number), "sensor_msgs/msg/Image")
            time = STAMP + number * 40_000_000
            writer.add_message(channel, time, bytes(data), time)
        writer.finish()
        return path.read_bytes()


def mcap_seeds() -> dict[str, bytes]:
    """Return mcap files with and without chunks, and one of a recorder that crashed."""
    plain = plain_mcap(None)
    return {
        "written": bag_files("mcap")["bag.mcap"],
        "plain": plain,
        "crashed": plain[: len(plain) // 2],
        "zstd": plain_mcap(CompressionType.ZSTD),
        "lz4": plain_mcap(CompressionType.LZ4),
    }


def sqlite_seeds() -> dict[str, bytes]:
    """Return a database of small pages, and one as rosbags writes it."""
    written = bag_files("sqlite3")["bag.db3"]
    with as_file(written, "seed.db3") as path:
        database = sqlite3.connect(path)
        database.execute("PRAGMA page_size = 512")
        database.execute("VACUUM")
        database.close()
        return {"small": path.read_bytes(), "written": written}


def ros1_seeds() -> dict[str, bytes]:
    """Return a ROS 1 bag of each compression."""
    seeds = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in ("NONE", "BZ2", "LZ4"):
            path = Path(folder) / f"{name}.bag"
            writer = Writer1(path)
            if name != "NONE":
                writer.set_compression(Writer1.CompressionFormat[name])
            with writer:
                fill(writer, 1)
            seeds[name.lower()] = path.read_bytes()
    return seeds


MCAP = plain_mcap(None)


def run_metadata(data: bytes) -> None:
    """A bag folder whose metadata are anything."""
    folder = scratch() / "bag"
    folder.mkdir(exist_ok=True)
    metadata, storage = folder / "metadata.yaml", folder / "bag.mcap"
    metadata.write_bytes(data)
    storage.write_bytes(MCAP)
    try:
        read_recording(folder)
    finally:
        metadata.unlink()
        storage.unlink()
        folder.rmdir()
        with suppress(OSError):
            folder.parent.rmdir()


def run_parameters(data: bytes) -> None:
    """A parameter file, and an initial state."""
    with as_file(data, "parameters.yaml") as path, suppress(ParameterError):
        parameters = CABLE.with_values("default", read_parameter_file(path))
        path.write_text(format_parameter_file(parameters, "again"), encoding="utf-8")
        again = CABLE.with_values("default", read_parameter_file(path))
        assert again == parameters
    with suppress(ParameterError):
        state = parse_initial_state(data.decode(errors="replace"))
        assert state is None or state.is_finite()


def run_target(data: bytes) -> None:
    """A parameter file of targets, where they begin as text, and a marked outline."""
    with as_file(data, "parameters.yaml") as path, suppress(ParameterError):
        values = read_parameter_file(path, "target_tracker")
        parameters = TargetParameters().replaced(
            {name: values[name] for name in values.keys() & TargetParameters().as_mapping().keys()}
        )
        assert TargetParameters().replaced(parameters.as_mapping()) == parameters
    with suppress(ParameterError):
        for box in parse_start_text(data.decode(errors="replace")).boxes:
            check_start(box)
    with suppress(FrameError):
        corners = np.frombuffer(data[: len(data) // 16 * 16], "<f8").reshape(-1, 2)
        check_start(TargetStart(corners))


def check_start(start: TargetStart) -> None:
    """A mark that a picture can hold has a mask in it."""
    with suppress(FrameError):
        start.check((64, 48))
        assert start.mask((48, 64), 1.0).shape == (48, 64)


TARGETS: Mapping[str, Target] = MappingProxyType(
    {
        "picture": Target(run_picture, picture_seeds),
        "raw_image": Target(run_raw_image, raw_image_seeds),
        "sequence_file": Target(run_sequence_file, sequence_file_seeds),
        "mcap": Target(run_file("dive.mcap"), mcap_seeds),
        "sqlite": Target(run_file("dive.db3"), sqlite_seeds),
        "ros1": Target(run_file("dive.bag"), ros1_seeds),
        "video": Target(run_file("dive.mp4"), video_seeds),
        "video_stream": Target(run_video_stream, video_stream_seeds),
        "metadata": Target(run_metadata, lambda: {"written": bag_files("mcap")["metadata.yaml"]}),
        "parameters": Target(
            run_parameters,
            lambda: {
                "file": format_parameter_file(TrackerParameters(), "All of them.").encode(),
                "state": b"12.0,0.1,40,0.03",
            },
        ),
        "target": Target(
            run_target,
            lambda: {
                "file": b"target_tracker: {ros__parameters: {particle_count: 70, seed: 3}}",
                "boxes": b"1.0,2.5,30,40;3,4,10,20",
                "word": b"detect",
                "outline": np.array([[3.0, 4.0], [30.0, 5.0], [20.0, 40.0]]).tobytes(),
            },
        ),
    }
)
