import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "cable_tracker"

MAY_IMPORT = {
    "particle_filter": set(),
    "cable": {"particle_filter"},
    "sequences": {"cable", "particle_filter"},
    "detection": {"cable"},
    "visualisation": {"sequences", "cable"},
    "simulation": {"sequences", "cable"},
    "evaluation": {"simulation", "detection", "visualisation", "sequences", "cable"},
    "ros": {"evaluation", "visualisation", "sequences", "cable", "particle_filter"},
    "commands": {"ros", "evaluation", "simulation", "detection", "sequences", "cable"},
}
ROS_PACKAGES = {
    "ament_index_python", "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "launch",
    "launch_ros", "rcl_interfaces", "rclpy", "rosgraph_msgs", "sensor_msgs", "std_msgs",
    "std_srvs", "visualization_msgs",
}  # fmt: skip


def imported_modules(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names)


def folders_imported_by(folder: str) -> set[str]:
    parts = [
        module.split(".")
        for path in (PACKAGE / folder).rglob("*.py")
        for module in imported_modules(path)
    ]
    named = {part[1] for part in parts if part[0] == "cable_tracker" and len(part) > 1}
    return {name for name in named if (PACKAGE / name).is_dir()}


def test_every_folder_has_its_place():
    folders = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert folders == set(MAY_IMPORT)


@pytest.mark.parametrize("folder", MAY_IMPORT)
def test_imports_run_one_way(folder):
    assert folders_imported_by(folder) <= MAY_IMPORT[folder] | {folder}


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda path: path.name)
def test_only_the_folder_ros_imports_ros(path):
    imported = {module.split(".")[0] for module in imported_modules(path)}
    assert path.parent.name == "ros" or not imported & ROS_PACKAGES


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda path: path.name)
def test_randomness_comes_from_a_generator_that_is_passed_in(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    used = {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Attribute)
        and node.value.attr == "random"
    }
    assert used <= {"Generator", "default_rng", "SeedSequence", "PCG64", "Philox"}
