from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from cable_tracker.cable.model.state import CableState
from cable_tracker.sequences.bags.rosbags_paths import BagFileWriter
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame

STORES = {2: get_typestore(Stores.ROS2_JAZZY), 1: get_typestore(Stores.ROS1_NOETIC)}
STEP = 40_000_000
FIRST = 1_700_000_000_000_000_000


@dataclass(frozen=True)
class BagPlan:
    """What a bag made for a test holds."""

    frames: int = 5
    storage: str = "mcap"
    compression: str = "none"
    compressed_images: bool = False
    both_types: bool = False
    """Whether each picture is followed by one of the other type, compressed or not."""
    truth: bool = True
    topics: tuple[str, ...] = ("/camera/image",)
    stamped: bool = True
    bad_frame: int | None = None
    cut_frame: int | None = None
    """Of its message only so many bytes are left:"""
    left: int = 0
    first_stamp: int = FIRST
    """Of the clock of the camera."""
    size: tuple[int, int] = (32, 24)
    chunk: int = 1 << 20
    """After so many bytes a ROS 1 bag begins another chunk."""


class MessageMaker:
    """Messages of one generation of ROS."""

    def __init__(self, ros: int) -> None:
        self.store: Typestore = STORES[ros]
        self.ros = ros

    def header(self, stamp: int) -> Any:
        types = self.store.types
        sec, nanosec = divmod(stamp, 1_000_000_000)
        time = types["builtin_interfaces/msg/Time"](sec=sec, nanosec=nanosec)
        extra = {"seq": 0} if self.ros == 1 else {}
        return types["std_msgs/msg/Header"](stamp=time, frame_id="eye", **extra)

    def image(self, stamp: int, picture: np.ndarray, **changes: Any) -> Any:
        height, width = picture.shape[:2]
        fields: dict[str, Any] = {
            "header": self.header(stamp),
            "height": height,
            "width": width,
            "encoding": "mono8",
            "is_bigendian": 0,
            "step": width,
            "data": picture.reshape(-1),
        }
        return self.store.types["sensor_msgs/msg/Image"](**{**fields, **changes})

    def compressed(self, stamp: int, picture: np.ndarray) -> Any:
        return self.store.types["sensor_msgs/msg/CompressedImage"](
            header=self.header(stamp),
            format="png",
            data=np.frombuffer(cv2.imencode(".png", picture)[1].tobytes(), np.uint8),
        )

    def truth(self, stamp: int, state: CableState) -> Any:
        return self.store.types["sensor_msgs/msg/JointState"](
            header=self.header(stamp),
            name=["d", "alpha", "w", "beta"],
            position=np.array([state.distance, state.angle, state.width, state.skew]),
            velocity=state.to_array()[4:],
            effort=np.array([]),
        )

    def text(self, content: str) -> Any:
        return self.store.types["std_msgs/msg/String"](data=content)

    def serialise(self, message: Any) -> bytes:
        name = message.__msgtype__
        if self.ros == 1:
            return bytes(self.store.serialize_ros1(message, name))
        return bytes(self.store.serialize_cdr(message, name))


def picture_of(index: int, size: tuple[int, int] = (32, 24)) -> np.ndarray:
    noise = np.random.default_rng(index).integers(0, 256, size[::-1], dtype=np.uint8)
    noise[0, 0] = index
    return noise


def state_of(index: int) -> CableState:
    return CableState(index + 0.5, 0.1, 30.0, 0.01, 2.0, -0.25, 1.5, 0.125)


def _image_message(maker: MessageMaker, plan: BagPlan, index: int) -> Any:
    stamp = plan.first_stamp + index * STEP if plan.stamped else 0
    picture = picture_of(index, plan.size)
    bad = index == plan.bad_frame
    if plan.compressed_images:
        message = maker.compressed(stamp, picture)
        if bad:
            message.data = message.data[: len(message.data) // 2]
        return message
    return maker.image(stamp, picture, **({"step": 3} if bad else {}))


def _fill(writer: Any, maker: MessageMaker, plan: BagPlan) -> None:
    connections: dict[tuple[str, str], Any] = {}
    other = replace(plan, compressed_images=not plan.compressed_images)

    def write(topic: str, message: Any, time: int, left: int | None = None) -> None:
        kind = topic, message.__msgtype__
        if kind not in connections:
            connections[kind] = writer.add_connection(*kind, typestore=maker.store)
        writer.write(connections[kind], time, maker.serialise(message)[:left])

    for index in range(plan.frames):
        stamp = FIRST + index * STEP
        for topic in plan.topics:
            left = plan.left if index == plan.cut_frame else None
            write(topic, _image_message(maker, plan, index), stamp + 1000, left)
            if plan.both_types:
                write(topic, _image_message(maker, other, index), stamp + 1500)
        if plan.truth and index % 2 == 0:
            header_stamp = plan.first_stamp + index * STEP if plan.stamped else 0
            write("/sim/ground_truth", maker.truth(header_stamp, state_of(index)), stamp + 1000)
        write("/chatter", maker.text("hello"), stamp + 2000)


@pytest.fixture
def make_bag(tmp_path: Path) -> Callable[..., Path]:
    """Write a ROS 2 bag, return its folder."""

    def make(name: str = "bag", **changes: Any) -> Path:
        plan = BagPlan(**changes)
        path = tmp_path / name
        writer = BagFileWriter(path, version=9, storage_plugin=StoragePlugin[plan.storage.upper()])
        writer.set_compression(CompressionMode[plan.compression.upper()], CompressionFormat.ZSTD)
        with writer:
            _fill(writer, MessageMaker(2), plan)
        return path

    return make


@pytest.fixture
def make_ros1_bag(tmp_path: Path) -> Callable[..., Path]:
    """Write a ROS 1 bag, return its file."""

    def make(name: str = "old.bag", **changes: Any) -> Path:
        plan = BagPlan(**changes)
        path = tmp_path / name
        writer = Writer1(path)
        writer.chunk_threshold = plan.chunk
        if plan.compression != "none":
            writer.set_compression(Writer1.CompressionFormat[plan.compression.upper()])
        with writer:
            _fill(writer, MessageMaker(1), plan)
        return path

    return make


@pytest.fixture
def maker() -> MessageMaker:
    return MessageMaker(2)


@pytest.fixture
def picture() -> Callable[..., np.ndarray]:
    return picture_of


@pytest.fixture
def state() -> Callable[[int], CableState]:
    return state_of


@pytest.fixture
def first_stamp() -> int:
    return FIRST


@pytest.fixture
def make_frame() -> Callable[..., Frame]:
    """Make a mono8 frame with a number written in its first pixel."""

    def make(index: int, truth: CableState | None = None) -> Frame:
        return Frame(index, index * STEP, raw_from_array(picture_of(index), "mono8"), truth=truth)

    return make


@pytest.fixture
def make_video(tmp_path: Path) -> Callable[..., Path]:
    """Write a video of grey frames, frame i of brightness 10 * i up to i = 24."""

    def make(name: str = "dive.avi", frames: int = 10, rate: float = 20.0) -> Path:
        path = tmp_path / name
        code = {".avi": "MJPG", ".mp4": "mp4v", ".webm": "VP80", ".mkv": "MJPG"}[path.suffix]
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), rate, (64, 48))
        assert writer.isOpened()
        for index in range(frames):
            writer.write(np.full((48, 64, 3), 10 * (index % 25), np.uint8))
        writer.release()
        return path

    return make


@pytest.fixture
def write_video(tmp_path: Path) -> Callable[..., Path]:
    """Write a video whose frames have given times [ms]."""

    def write(
        name: str,
        times: Sequence[float | Fraction],
        *,
        codec: str = "libx264",
        b_frames: int = 0,
        rate: Fraction | int = 25,
        ticks: int = 90_000,
        turn: int = 0,
    ) -> Path:
        path, noise = tmp_path / name, np.random.default_rng(0)
        with av.open(str(path), "w") as container:
            stream = container.add_stream(codec, rate=rate, options={"bf": str(b_frames)})
            stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
            stream.codec_context.time_base = Fraction(1, ticks)
            if turn:
                stream.set_display_rotation(turn)
            for time in times:
                picture = noise.integers(0, 255, (48, 64, 3), np.uint8)
                frame = av.VideoFrame.from_ndarray(picture, format="bgr24")
                frame.time_base, frame.pts = Fraction(1, ticks), round(time * ticks / 1000)
                container.mux(stream.encode(frame))
            container.mux(stream.encode(None))
        return path

    return write


@pytest.fixture
def footage(real_footage: Callable[..., Path]) -> Path:
    """Folder of the real video of a strip and of its labels."""
    return real_footage("strip", "strip.mp4", "strip.txt")


@pytest.fixture
def pictures(tmp_path: Path, picture: Callable[..., np.ndarray]) -> Path:
    """Return a folder of four pictures, 0.png to 3.png."""
    folder = tmp_path / "pictures"
    folder.mkdir()
    for index in range(4):
        cv2.imwrite(str(folder / f"{index}.png"), picture(index))
    return folder
