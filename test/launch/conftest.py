"""Launch files are played by a stand-in: PyPI has no `launch`."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture(scope="session")
def jazzy() -> ModuleType:
    """The stand-in for launch and launch_ros of Jazzy."""
    name = "jazzy_launch_stand_in"
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name("jazzy_launch.py"))
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # Dataclasses look their module up.
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
