"""Run the tests as other processors, and a busy one, would.

`python test/processors.py [--only NAME] [arguments of pytest]`, or `make test-processors`. Each
setting takes away what one library makes of this processor; the last bits of what it computes then
differ, as they do on another machine. Settings of this machine that its libraries do not know are
left out.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import platform
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
CACHE = ROOT / ".venv" / "cache"
GLIBC_FEATURES = ("AVX512F", "AVX512VL", "AVX2", "FMA", "AVX")
BUSY_LOOPS = 4


@dataclass(frozen=True)
class Setting:
    """Environment of a run of the tests, and how many loops keep the machine busy beside it."""

    name: str
    environment: dict[str, str] = field(default_factory=dict)
    busy_loops: int = 0


def numpy_features() -> list[str]:
    """Return what NumPy chooses kernels by, of what this processor has."""
    core = np._core if hasattr(np, "_core") else np.core
    umath = core._multiarray_umath
    return [name for name in umath.__cpu_dispatch__ if umath.__cpu_features__[name]]


def opencv_features() -> list[str]:
    """Return what OpenCV chooses kernels by: it marks them with a star."""
    names = cv2.getCPUFeaturesLine().split()
    return [name[1:] for name in names if name.startswith("*") and not name.endswith("?")]


def settings() -> list[Setting]:
    """Return all settings that change something here."""
    found = [
        Setting(
            "numba",
            {"NUMBA_CPU_NAME": "generic", "NUMBA_CACHE_DIR": str(CACHE / "numba_generic")},
        )
    ]
    if names := numpy_features():
        found.append(Setting("numpy", {"NPY_DISABLE_CPU_FEATURES": " ".join(names)}))
    if names := opencv_features():
        found.append(Setting("opencv", {"OPENCV_CPU_DISABLE": ",".join(names)}))
    if platform.machine() == "x86_64" and platform.libc_ver()[0] == "glibc":
        without = ",".join(f"-{name}" for name in GLIBC_FEATURES)
        found.append(Setting("libm", {"GLIBC_TUNABLES": f"glibc.cpu.hwcaps={without}"}))
    return [*found, Setting("busy", busy_loops=BUSY_LOOPS)]


def _spin() -> None:
    while True:
        pass


@contextmanager
def busy(count: int) -> Iterator[None]:
    """Keep so many processors busy."""
    loops = [multiprocessing.Process(target=_spin, daemon=True) for _ in range(count)]
    for loop in loops:
        loop.start()
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.join()


def run(setting: Setting, arguments: list[str]) -> int:
    """Run pytest under a setting; return its exit code."""
    told = " ".join(f"{name}={value}" for name, value in setting.environment.items())
    print(f"== {setting.name}: {told or f'{setting.busy_loops} busy loops'}", flush=True)
    with busy(setting.busy_loops):
        return subprocess.run(
            [sys.executable, "-m", "pytest", *arguments],
            cwd=ROOT,
            env=os.environ | setting.environment,
            check=False,
        ).returncode


def main() -> int:
    """Run pytest under the settings; return 1 if it fails under any."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=[each.name for each in settings()], action="append")
    chosen, arguments = parser.parse_known_args()
    summary = []
    for setting in settings():
        if chosen.only is None or setting.name in chosen.only:
            begin = time.monotonic()
            code = run(setting, arguments)
            summary.append((setting.name, code, time.monotonic() - begin))
    for name, code, seconds in summary:
        print(f"{name:8} {'passed' if code == 0 else f'exit code {code}':14} {seconds:6.0f} s")
    return int(any(code for _, code, _ in summary))


if __name__ == "__main__":
    sys.exit(main())
