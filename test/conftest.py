"""Settings for all tests, and what stands in which tier."""

import copy
import errno
import faulthandler
import gc
import importlib.util
import os
import pickle
import sys
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import pytest
from hypothesis import HealthCheck, settings

# The first call of a compiled function takes seconds, and no test is about time.
UNTIMED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("untimed", UNTIMED)
settings.register_profile("quick", UNTIMED, max_examples=25)
settings.load_profile("untimed")

ROOT = Path(__file__).parent
BROWSER_FIXTURE = "chromium"
TRUE_STDERR = pytest.StashKey[int]()

KEPT_MAPS = 160
"""More than the longest dive that many tests are shown has frames."""

KEPT_SURFACES = 12
"""Beds and cables of so many dives [each]; the finest of them have 15 MB."""


STUCK = 2.5
"""A process that is still at one test after so many times its time limit ends."""


def pytest_configure(config: pytest.Config) -> None:
    """Keep the true standard error, for what a process that is stuck has to say."""
    config.stash[TRUE_STDERR] = os.dup(2)


def end_if_stuck(config: pytest.Config) -> None:
    """End this process later, with its stacks, so that the run names its test and goes on.

    The time limit of a test cannot: it interrupts no compiled code, and acts once, so that what
    hangs while it cleans up after a late test hangs for ever. Without a limit, as for a debugger,
    nothing ends.
    """
    limit = config.getoption("timeout", None)
    if limit:
        faulthandler.dump_traceback_later(STUCK * limit, exit=True, file=config.stash[TRUE_STDERR])


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Watch over a test from the first of its fixtures to the end of the last."""
    end_if_stuck(item.config)
    try:
        return (yield)
    finally:
        faulthandler.cancel_dump_traceback_later()


@pytest.hookimpl(trylast=True)
def pytest_exception_interact(node: pytest.Item | pytest.Collector) -> None:
    """Watch on after a failure, at which pytest calls off what may end the process."""
    if isinstance(node, pytest.Item):
        end_if_stuck(node.config)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Look for no garbage meanwhile, nor ever again in what was collected: it stays to the end."""
    gc.disable()
    yield
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark tests by where they stand and by the fixtures they ask for."""
    for item in items:
        place = item.path.relative_to(ROOT).as_posix()
        if place.startswith("ros/"):
            item.add_marker(pytest.mark.ros)
        if BROWSER_FIXTURE in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.browser)


@pytest.fixture(scope="session", autouse=True)
def kept_maps() -> Iterator[None]:
    """Keep what the network says of a picture, for most are shown to many filters.

    `test_map_network.py` asks the network itself, and holds that it always says the same.
    """
    # The process that only distributes the tests needs none of this.
    import numpy as np  # noqa: PLC0415

    from cable_tracker.arrays import Image  # noqa: PLC0415
    from cable_tracker.cable.measure.map.cable_map import CableMap  # noqa: PLC0415
    from cable_tracker.cable.measure.picture import working_image  # noqa: PLC0415

    make_cable_map = working_image.make_cable_map

    @lru_cache(KEPT_MAPS)
    def made(pixels: bytes, shape: tuple[int, ...], kind: np.dtype, frame_width: int) -> CableMap:
        return make_cable_map(np.frombuffer(pixels, kind).reshape(shape), frame_width)

    def kept(picture: Image, frame_width: int) -> CableMap:
        return copy.deepcopy(made(picture.tobytes(), picture.shape, picture.dtype, frame_width))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(working_image, "make_cable_map", kept)
        yield


@pytest.fixture(scope="session", autouse=True)
def kept_surfaces() -> Iterator[None]:
    """Keep the bottom and the cable of a simulated dive, for most tests dive where others did.

    `test_seabed.py` makes them itself, and holds that the same draws always give the same.
    """
    from cable_tracker.simulation import dive  # noqa: PLC0415
    from cable_tracker.simulation.rendering.texture import TiledTexture  # noqa: PLC0415

    def keep(make: Callable[..., TiledTexture]) -> Callable[..., TiledTexture]:
        @lru_cache(KEPT_SURFACES)
        def made(resolution: int, look: Any, before: bytes) -> tuple[TiledTexture, Any]:
            rng = pickle.loads(before)
            texture = make(resolution, look, rng)
            for level in texture.levels:
                level.setflags(write=False)
            return texture, rng.bit_generator.state

        def kept(resolution: int, look: Any, rng: Any) -> TiledTexture:
            texture, rng.bit_generator.state = made(resolution, look, pickle.dumps(rng))
            return texture

        return kept

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dive, "make_bed", keep(dive.make_bed))
        patch.setattr(dive, "make_cable", keep(dive.make_cable))
        yield


@pytest.fixture(scope="session")
def full_disk() -> Callable[..., None]:
    """Stand in for what writes, on a disk that is full."""

    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    return refuse


@pytest.fixture(scope="session")
def real_footage() -> Callable[..., Path]:
    """Find a folder of real pictures, which are no part of the repository."""

    def found(name: str, *files: str) -> Path:
        folder = ROOT.parents[1] / "shared" / "data" / name
        if not all((folder / file).exists() for file in files or ("",)):
            pytest.skip(f"REAL FOOTAGE IS MISSING: {folder} {' '.join(files)}".rstrip())
        return folder

    return found


class Outcome(NamedTuple):
    """How a command ended, and what it wrote."""

    code: int
    out: str
    err: str

    def assert_refused(self, words: str) -> None:
        """One line on stderr, exit code 2."""
        assert self.code == 2
        assert self.out == ""
        assert self.err.startswith("error: ")
        assert self.err.count("\n") == 1
        assert words in self.err

    def assert_broken_off(self, frames: int, words: str) -> None:
        """So many frames are used; one line on stderr, exit code 2."""
        assert self.code == 2
        assert self.out.startswith(f"{frames} frames: ")
        assert self.err.startswith("error: ")
        assert self.err.count("\n") == 1
        assert words in self.err


@pytest.fixture(scope="session")
def exit_code() -> Callable[..., int]:
    """Run `cable-tracker` where this process is."""
    from cable_tracker import cli  # noqa: PLC0415

    def run_command(*arguments: object) -> int:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(sys, "argv", ["cable-tracker", *map(str, arguments)])
            try:
                cli.main()
            except SystemExit as end:
                return end.code if isinstance(end.code, int) else 0
        return 0

    return run_command


@pytest.fixture
def command(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    exit_code: Callable[..., int],
) -> Callable[..., Outcome]:
    """Run `cable-tracker` in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run_command(*arguments: object) -> Outcome:
        capsys.readouterr()
        return Outcome(exit_code(*arguments), *capsys.readouterr())

    return run_command


@pytest.fixture(scope="session")
def draw_strip() -> Callable[..., Any]:
    """Draw an ideal strip between two soft straight borders; uint8."""
    import numpy as np  # noqa: PLC0415

    from cable_tracker.arrays import Image  # noqa: PLC0415
    from cable_tracker.cable.model.geometry import project_borders  # noqa: PLC0415
    from cable_tracker.cable.model.state import CableState  # noqa: PLC0415

    def drawn(
        state: CableState, size: tuple[int, int] = (320, 240), *, strip=200.0, ground=60.0, blur=1.0
    ) -> Image:
        width, height = size
        x = (np.arange(width) - (width - 1) / 2)[None, :]
        y = ((height - 1) / 2 - np.arange(height))[:, None]
        borders = project_borders(state.to_array()[None, :])
        (left, right), (low, high) = borders.angles[0], borders.offsets[0]
        inside = 1.0
        for angle, offset, sign in ((left, low, 1.0), (right, high, -1.0)):
            across = sign * (x * np.cos(angle) + y * np.sin(angle) - offset)
            inside = inside * (1 + np.tanh(across / blur)) / 2
        return np.rint(ground + (strip - ground) * inside).astype(np.uint8)

    return drawn


@pytest.fixture(scope="session")
def jazzy() -> ModuleType:
    """Stand in for launch and launch_ros of Jazzy: PyPI has no `launch`."""
    name = "jazzy_launch_stand_in"
    spec = importlib.util.spec_from_file_location(name, ROOT / "launch" / "jazzy_launch.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # Dataclasses look their module up.
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
