import ast
from functools import cache
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "cable_tracker"
MODULES = sorted(PACKAGE.rglob("*.py"))

ALL_MAY_IMPORT = {
    "arrays",
    "atomic_output",
    "cholesky",
    "compilation",
    "errors",
    "libraries",
    "printable",
    "stamps",
}
MAY_IMPORT = {
    "arrays": set(),
    "numba_linking": set(),
    "compilation": {"numba_linking"},
    "cholesky": set(),
    "errors": set(),
    "folder_lock": set(),
    "printable": set(),
    "atomic_output": {"folder_lock"},
    "marked_page": set(),
    "stamps": set(),
    "libraries": set(),
    "resources": set(),
    "particle_filter": set(),
    "contour": set(),
    "tracking": set(),
    "cable": {"tracking", "particle_filter"},
    "target": {"contour", "tracking", "particle_filter"},
    "node_parameter_tables": {"cable", "target", "tracking"},
    "followed_kinds": {"node_parameter_tables", "cable", "target", "tracking"},
    "sequences": {"cable", "target", "tracking", "particle_filter"},
    "metric": {"sequences", "node_parameter_tables", "cable", "target", "tracking"},
    "detection": {"cable", "tracking"},
    "trackers": {"cable", "tracking", "detection", "particle_filter"},
    "visualisation": {"sequences", "cable", "target", "tracking"},
    "simulation": {"sequences", "metric", "cable", "tracking"},
    "campaigns": set(),
    "survey": {
        "campaigns", "trackers", "detection", "metric", "sequences", "cable", "tracking",
    },
    "evaluation": {
        "campaigns", "trackers", "simulation", "detection", "visualisation", "sequences", "metric",
        "node_parameter_tables", "cable", "target", "tracking", "particle_filter",
    },
    "offline": {
        "trackers", "detection", "visualisation", "sequences", "metric", "cable", "target",
        "tracking", "particle_filter",
    },
    "gui": {
        "trackers", "offline", "evaluation", "detection", "visualisation", "metric",
        "sequences", "followed_kinds", "cable", "target", "tracking", "particle_filter",
    },
    "benchmark": {
        "contour", "evaluation", "trackers", "detection", "visualisation", "sequences", "cable",
        "tracking", "particle_filter", "marked_page",
    },
    "example_controller": {"tracking"},
    "ros": {
        "benchmark", "gui", "offline", "evaluation", "trackers", "simulation", "detection",
        "example_controller",
        "visualisation", "sequences", "followed_kinds",
        "node_parameter_tables", "metric", "cable", "target", "tracking", "particle_filter",
        "resources",
    },
    "commands": {
        "ros", "benchmark", "gui", "offline", "evaluation", "survey", "campaigns", "trackers",
        "simulation", "detection", "metric", "sequences", "followed_kinds",
        "node_parameter_tables", "cable", "target", "tracking", "resources",
    },
    "cli": {"commands"},
}  # fmt: skip
"""Of the folders and of the modules beside them, lowest first."""
ORDER_WITHIN = {
    "cable": [
        "parameters", "model", "measure", "learning", "filter_interface",
        "hypotheses", "thesis",
    ],
    "cable/measure": ["scan_filters", "scanned_gradients", "map", "picture", "borders"],
    "cable/hypotheses": [
        "clusters", "presence", "births", "predicted_density", "frame_inputs", "peaks", "proposals",
        "background", "evidence_correction", "vehicle_fixture", "belief", "conclusion",
        "cluster_estimates", "claim", "prediction", "multi_hypothesis_filter",
    ],
    "commands": [
        "console", "options", "many_runs", "chase", "convert", "dds_profile",
        "dev", "evaluate", "gui", "label", "learn", "loop", "parameters", "simulate", "survey",
        "target", "track", "warm_up",
    ],
    "gui": ["subject", "session", "web", "labelling", "tracking"],
    "simulation": [
        "settings", "rendering", "borders", "trajectory", "vehicle", "dive", "cable_scene",
        "scenarios", "scenario_dive", "worlds", "instruments", "live_world", "targets",
    ],
    "survey": [
        "memory_mapped", "frame_table", "picture_measurements", "forward_pass", "trajectory",
        "georeference", "keyframes", "curve_filter", "smoother", "routes", "redetection", "outputs",
        "dive_faults", "recording", "campaign",
    ],
}  # fmt: skip
"""Folders and modules of a folder, lowest first: each may import those before it."""
ROS_PACKAGES = {
    "ament_index_python", "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "launch",
    "launch_ros", "nav_msgs", "rcl_interfaces", "rclpy", "rosgraph_msgs", "sensor_msgs", "std_msgs",
    "std_srvs", "visualization_msgs",
}  # fmt: skip


USES_GLOBAL_STATE = {"library_filters.py": {"RandomState", "get_state", "set_state"}}
"""Rivals in the benchmark know no generator; theirs is kept apart from all others'."""


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imported_modules(path: Path) -> list[str]:
    modules = []
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Import):
            modules += [name.name for name in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            modules += [node.module, *(f"{node.module}.{name.name}" for name in node.names)]
    return modules


def parts_of(folder: Path) -> set[str]:
    folders = {path.parent.name for path in folder.glob("*/__init__.py")}
    return folders | {path.stem for path in folder.glob("*.py")} - {"__init__"}


def parts_imported_by(part: str, folder: Path = PACKAGE) -> set[str]:
    """Parts of a folder that one of them imports."""
    paths = [folder / f"{part}.py", *(folder / part).rglob("*.py")]
    modules = {module for path in paths if path.is_file() for module in imported_modules(path)}
    above = ".".join(folder.relative_to(PACKAGE.parent).parts) + "."
    inside = {module.removeprefix(above) for module in modules if module.startswith(above)}
    return {module.split(".")[0] for module in inside} & parts_of(folder)


def test_every_part_has_its_place():
    assert parts_of(PACKAGE) == set(MAY_IMPORT)


def test_imports_within_a_folder_run_one_way():
    for folder, order in ORDER_WITHIN.items():
        assert parts_of(PACKAGE / folder) == set(order), folder
        for place, part in enumerate(order):
            assert parts_imported_by(part, PACKAGE / folder) <= set(order[: place + 1]), part


def test_allowed_imports_stand_below_the_part():
    order = list(MAY_IMPORT)
    for part, lower in MAY_IMPORT.items():
        assert all(order.index(name) < order.index(part) for name in lower), part


def test_imports_run_one_way():
    for part, lower in MAY_IMPORT.items():
        assert parts_imported_by(part) <= lower | ALL_MAY_IMPORT | {part}, part


def tops_imported_by(path: Path) -> set[str]:
    """First parts of the names of imported modules."""
    return {module.split(".")[0] for module in imported_modules(path)}


def random_names_used_by(path: Path) -> set[str]:
    return {
        node.attr
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Attribute)
        and node.value.attr == "random"
    }


@pytest.mark.parametrize(
    ("folder", "packages"),
    [("ros", ROS_PACKAGES), ("gui", {"nicegui", "starlette", "fastapi", "uvicorn"})],
)
def test_only_one_folder_imports_what_is_its_own(folder, packages):
    importing = [path for path in MODULES if tops_imported_by(path) & packages]
    assert importing
    assert [path for path in importing if PACKAGE / folder not in path.parents] == []


def test_randomness_comes_from_a_generator_that_is_passed_in():
    allowed = {"Generator", "default_rng", "SeedSequence", "PCG64", "Philox"}
    others = {
        path.name: names
        for path in MODULES
        if (names := random_names_used_by(path) - allowed - USES_GLOBAL_STATE.get(path.name, set()))
    }
    assert others == {}


@cache
def path_of(module: str) -> Path | None:
    """Return the file of a module of this package; None: it is no module, or of another package."""
    path = PACKAGE.parent.joinpath(*module.split("."))
    found = [each for each in (path.with_suffix(".py"), path / "__init__.py") if each.is_file()]
    return found[0] if found and module.startswith("cable_tracker.") else None


def imported_at_once(path: Path) -> set[str]:
    """Names that a module imports when it is itself imported, not later in one of its functions."""
    modules = set()
    for node in tree_of(path).body:
        if isinstance(node, ast.Import):
            modules |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            modules |= {node.module, *(f"{node.module}.{name.name}" for name in node.names)}
    return modules


def all_imported_with(path: Path) -> set[str]:
    """Names that are imported with a module, also by what it imports in turn."""
    names, seen, left = set(), set(), {path}
    while left:
        each = left.pop()
        seen.add(each)
        found = imported_at_once(each)
        names |= found
        left |= {path for name in found if (path := path_of(name))} - seen
    return names


@pytest.mark.parametrize("node", ["tracker_node", "target_tracker_node"])
def test_tracker_nodes_do_not_import_libraries_that_unpack_recordings(node):
    """It takes a quarter of the time in which a node would start."""
    tops = {name.split(".")[0] for name in all_imported_with(PACKAGE / f"ros/nodes/{node}.py")}
    assert "numpy" in tops
    assert not tops & {"rosbags", "av", "mcap", "ruamel", "zstandard"}
