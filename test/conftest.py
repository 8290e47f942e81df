"""Settings for all tests, and what stands in which tier."""

from pathlib import Path

import pytest
from hypothesis import settings

# The first call of a compiled function takes seconds, and no test is about time.
settings.register_profile("untimed", deadline=None)
settings.register_profile("quick", deadline=None, max_examples=25)
settings.load_profile("untimed")

ROOT = Path(__file__).parent
SLOW = {
    "benchmark/test_library_filters.py",
    "benchmark/test_round_robin.py",
    "commands/test_bench.py",
    "commands/test_experiment.py",
    "commands/test_loop_campaign.py",
    "commands/test_outputs.py",
    "commands/test_soak.py",
    "evaluation/test_ablation.py",
    "evaluation/test_aided.py",
    "evaluation/test_baselines.py",
    "evaluation/test_campaign.py",
    "evaluation/test_flights.py",
    "evaluation/test_metres_experiment.py",
    "evaluation/test_motion_experiment.py",
    "fuzz/test_fuzz.py",
    "ros/test_endurance.py",
    "ros/test_soak.py",
    "ros/test_stream_faults.py",
    "simulation/test_photographs.py",
}
"""Files whose tests have the marker `slow`: experiments, endurance, and tools of the team."""
BROWSER_FIXTURE = "chromium"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark tests by where they stand and by the fixtures they ask for."""
    for item in items:
        place = item.path.relative_to(ROOT).as_posix()
        if place in SLOW:
            item.add_marker(pytest.mark.slow)
        if place.startswith("ros/"):
            item.add_marker(pytest.mark.ros)
        if BROWSER_FIXTURE in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.browser)


def pytest_sessionstart() -> None:
    """Refuse to run with names of slow files that are gone."""
    gone = sorted(name for name in SLOW if not (ROOT / name).is_file())
    if gone:
        raise pytest.UsageError(f"test/conftest.py names files that are gone: {', '.join(gone)}")
