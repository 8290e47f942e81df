"""Where the files lie that ship with the package: presets, launch files, the DDS profile."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

from cable_tracker.errors import ResourceError

PACKAGE = "cable_tracker"
MARKER = "package.xml"
"""A folder with this file in it is the share folder, or the source checkout."""

DDS_PROFILE = Path("config") / "fastdds_loopback.xml"


def _candidates() -> Iterator[Path]:
    # The order of colcon: what the sourced workspaces name, then the source, then this environment.
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix:
            yield Path(prefix) / "share" / PACKAGE
    yield Path(__file__).resolve().parents[1]
    yield Path(sys.prefix) / "share" / PACKAGE


def share_folder() -> Path:
    """Return the folder that holds config/ and launch/.

    Raises
    ------
    ResourceError
        The folder is in none of the usual places.
    """
    tried = list(_candidates())
    for folder in tried:
        if (folder / MARKER).is_file() and (folder / "config").is_dir():
            return folder
    raise ResourceError(
        f"config/ of {PACKAGE} is in none of {', '.join(map(str, tried))};"
        " install the package anew, or source its workspace"
    )


def resource(relative: Path) -> Path:
    """Return the path of a shipped file.

    Raises
    ------
    ResourceError
        The file is not there.
    """
    path = share_folder() / relative
    if not path.is_file():
        raise ResourceError(f"{path} is missing; install the package anew")
    return path
