"""Facts in a report about how and where it was made."""

from __future__ import annotations

import os
import platform
import shlex
import sys
from datetime import date
from pathlib import Path

import cv2
import numpy as np

from cable_tracker import __version__

CPU_INFORMATION = Path("/proc/cpuinfo")


def typed_command(*, without: str | None = None) -> str:
    """Return the command line as it was typed, but for an option and its value."""
    arguments = [each for each in sys.argv[1:] if not each.startswith(f"{without}=")]
    if without in arguments:
        index = arguments.index(without)
        del arguments[index : index + 2]
    return shlex.join(("cable-tracker", *arguments))


def machine() -> str:
    """Describe processor, system and versions in one line."""
    return (
        f"{_processor()}, {os.cpu_count()} processors, {platform.system()};"
        f" cable_tracker {__version__}, Python {platform.python_version()}, NumPy {np.__version__},"
        f" OpenCV {cv2.__version__}"
    )


def origin_note() -> str:
    """Say in Markdown with which command, when and on which machine a report was made."""
    return f"`{typed_command()}` on {date.today().isoformat()}, {machine()}."


def _processor() -> str:
    if CPU_INFORMATION.is_file():
        for line in CPU_INFORMATION.read_text(encoding="utf-8", errors="replace").splitlines():
            name, _, value = line.partition(":")
            if name.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()
