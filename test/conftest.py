"""Settings for all tests, and what stands in which tier."""

import gc
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# The first call of a compiled function takes seconds, and no test is about time.
UNTIMED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("untimed", UNTIMED)
settings.register_profile("quick", UNTIMED, max_examples=25)
settings.load_profile("untimed")

ROOT = Path(__file__).parent
BROWSER_FIXTURE = "chromium"


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
