"""Write config/*.yaml, docs/parameters.md and docs/api.md from the code.

Run by `make docs`; a test sees to it that the files are up to date.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE, TrackerParameters
from cable_tracker.cable.parameters.presets import PRESETS, preset
from cable_tracker.example_controller.controller import ControllerSettings
from cable_tracker.example_controller.target_follower import FollowSettings
from cable_tracker.metric.altitude import Altitude
from cable_tracker.metric.calibration import Calibration
from cable_tracker.metric.cross_track import CrossTrack, CrossTrackMeter, MetricSettings
from cable_tracker.metric.frames import Attitude, Mounting
from cable_tracker.metric.withheld import Withheld
from cable_tracker.node_parameter_tables import (
    TARGET_RUNTIME_PARAMETERS,
    TARGET_START_PARAMETERS,
    TRACKER_RUNTIME_PARAMETERS,
    TRACKER_START_PARAMETERS,
    GuidanceNodeParameters,
    ReplayRuntimeParameters,
    ReplayStartParameters,
    SimulatorNodeParameters,
    VehicleNodeParameters,
)
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.source import open_source
from cable_tracker.simulation.live_world import LiveSettings
from cable_tracker.simulation.targets.chase import ChaseSettings
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.parameters.presets import TARGET_PRESETS, target_preset
from cable_tracker.target.tracker import TargetTracker
from cable_tracker.trackers import CableTracker, make_tracker, warm_up
from cable_tracker.tracking.parameter_files import format_parameter_file
from cable_tracker.tracking.parameter_table import ParameterSet, ParameterSpec, parameter_table

ROOT = Path(__file__).resolve().parents[1]

TITLES = {
    "default": "Preset `default`: what to begin with. Written by `make docs`.",
    "pipeline": "Preset `pipeline`: wide pipes as inspections see them. Written by `make docs`.",
    "thesis": "Preset `thesis`: Wirth (2008), Tables 5.1, 5.2. Written by `make docs`.",
}

TARGET_TITLES = {
    name: f"Preset `{name}` of targets: {what} Written by `make docs`."
    for name, what in {
        "default": "what to begin with.",
        "thesis": "Ha (2008), Table 7 with the weights of (30).",
        "docking": "rigid, approached slowly.",
        "diver": "a shape that changes fast.",
    }.items()
}

INTRODUCTION = """\
# Parameters

Made from the classes derived from `ParameterSet` in `cable_tracker/` by `make docs`; do not edit.

Lengths are for an image 320 px wide and scale with the image. Variances and rates are per frame at
25 frames per second and scale with the real time between frames. A whole number is accepted where
a float is meant. What comes in one call of `set_parameters_atomically` is taken as a whole or not
at all; `ros2 param set` and `set_parameters` send one value after the other, and each is taken or
refused for itself. A refusal says why and leaves the node as it was. A name that the node does not
have is warned of and ignored at its start; `cable-tracker track --params` refuses it.

## The filter

Parameters of the node `tracker`, of `cable-tracker track --params FILE`, and of
`TrackerParameters`. All can be changed while the node runs. `config/default.yaml`,
`config/pipeline.yaml` and `config/thesis.yaml` hold the presets.

"""


TARGET_INTRODUCTION = """\
Parameters of the node `target_tracker`, of `cable-tracker target --params FILE`, and of
`TargetParameters`; see [targets.md](targets.md). All can be changed while the node runs.
`config/target_*.yaml` hold the presets.

"""


def cell(value: object) -> str:
    """Write a value into a table."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value) or "(empty)"


def preset_table(specs: Iterable[ParameterSpec], presets: Mapping[str, ParameterSet]) -> str:
    """Return the table of a filter's parameters, with the values of all presets."""
    columns = {name: values.as_mapping() for name, values in presets.items()}
    lines = [
        f"| name | {' | '.join(columns)} | unit | range | meaning |",
        "|---" * (len(columns) + 4) + "|",
    ]
    for spec in specs:
        lines.append(row(spec, *(cell(values[spec.name]) for values in columns.values())))
    return "\n".join(lines) + "\n"


def row(spec: ParameterSpec, *values: str) -> str:
    """Return one row of a table."""
    limits, meaning = (text.replace("|", "\\|") for text in (spec.range_text(), spec.meaning))
    return f"| `{spec.name}` | {' | '.join(values)} | {spec.unit} | {limits} | {meaning} |"


def node_table(specs: Iterable[ParameterSpec]) -> str:
    """Return the table of a node's own parameters."""
    lines = ["| name | default | unit | range | meaning |", "|---|---|---|---|---|"]
    lines += [row(spec, cell(spec.default)) for spec in specs]
    return "\n".join(lines) + "\n"


def node_section(
    title: str, start: Sequence[ParameterSpec], runtime: Sequence[ParameterSpec] = ()
) -> str:
    """Return the section of a node: parameters that are read at start, and those that may change.

    There need be none that may change.
    """
    text = f"\n## {title}\n\nRead at start only:\n\n{node_table(start)}"
    return f"{text}\nMay be changed while it runs:\n\n{node_table(runtime)}" if runtime else text


def tables_of(*kinds: type[ParameterSet]) -> tuple[ParameterSpec, ...]:
    """Return the parameters of some sets, one set after the other."""
    return tuple(spec for kind in kinds for spec in parameter_table(kind))


def parameters_page() -> str:
    """Return docs/parameters.md."""
    presets = {name: PRESETS[name] for name in TITLES}
    return "".join(
        (
            INTRODUCTION,
            preset_table(PARAMETER_TABLE, presets),
            node_section(
                "The node `tracker` besides", TRACKER_START_PARAMETERS, TRACKER_RUNTIME_PARAMETERS
            ),
            node_section(
                "The node `replay`",
                parameter_table(ReplayStartParameters),
                parameter_table(ReplayRuntimeParameters),
            ),
            node_section("The node `simulator`", tables_of(LiveSettings, SimulatorNodeParameters)),
            node_section(
                "The node `controller`, an example",
                tables_of(ControllerSettings, GuidanceNodeParameters),
            ),
            node_section(
                "The node `target_simulator`", tables_of(ChaseSettings, VehicleNodeParameters)
            ),
            node_section(
                "The node `follower`, an example", tables_of(FollowSettings, GuidanceNodeParameters)
            ),
            "\n## The filter of targets\n\n",
            TARGET_INTRODUCTION,
            preset_table(parameter_table(TargetParameters), TARGET_PRESETS),
            node_section(
                "The node `target_tracker` besides",
                TARGET_START_PARAMETERS,
                TARGET_RUNTIME_PARAMETERS,
            ),
        )
    )


API = (
    (make_tracker, "cable_tracker.trackers"),
    (warm_up, "cable_tracker.trackers"),
    (preset, "cable_tracker.cable.parameters.presets"),
    (TrackerParameters.replaced, "cable_tracker.cable.parameters.parameters"),
    (CableTracker, "cable_tracker.trackers"),
    (CableTracker.process, "cable_tracker.trackers"),
    (CableTracker.initialise, "cable_tracker.trackers"),
    (CableTracker.reset, "cable_tracker.trackers"),
    (GivenState.around, "cable_tracker.cable.model.initial_state"),
    (CableEstimate, "cable_tracker.cable.model.estimate"),
    (CableState, "cable_tracker.cable.model.state"),
    (open_source, "cable_tracker.sequences.source"),
    (decode_grey, "cable_tracker.sequences.encodings"),
    (CrossTrackMeter, "cable_tracker.metric.cross_track"),
    (CrossTrackMeter.measure, "cable_tracker.metric.cross_track"),
    (CrossTrack, "cable_tracker.metric.cross_track"),
    (Withheld, "cable_tracker.metric.withheld"),
    (MetricSettings, "cable_tracker.metric.cross_track"),
    (Mounting, "cable_tracker.metric.frames"),
    (Calibration, "cable_tracker.metric.calibration"),
    (Altitude, "cable_tracker.metric.altitude"),
    (Attitude, "cable_tracker.metric.frames"),
    (TargetTracker, "cable_tracker.target.tracker"),
    (TargetTracker.initialise, "cable_tracker.target.tracker"),
    (TargetTracker.process, "cable_tracker.target.tracker"),
    (TargetTracker.reset, "cable_tracker.target.tracker"),
    (TargetStart, "cable_tracker.target.model.start"),
    (TargetStart.from_box, "cable_tracker.target.model.start"),
    (TargetEstimate, "cable_tracker.target.model.estimate"),
    (target_preset, "cable_tracker.target.parameters.presets"),
)
"""The public names, and the modules that they are imported from."""


def api_page() -> str:
    """Return docs/api.md."""
    parts = [
        "# The Python API\n\nMade from the docstrings by `make docs`; do not edit."
        " [python.md](python.md) shows how it is used.\n"
    ]
    for item, module in API:
        signature = str(inspect.signature(item)).replace("cable_tracker.", "")
        parts.append(f"\n## `{item.__qualname__}`\n\nFrom `{module}`.\n\n```text\n")
        parts.append(f"{item.__qualname__}{signature}\n\n{inspect.getdoc(item)}\n```\n")
    return "".join(parts)


def generated_files() -> dict[Path, str]:
    """Return the content of every generated file by its path."""
    files = {
        ROOT / "docs" / "parameters.md": parameters_page(),
        ROOT / "docs" / "api.md": api_page(),
    }
    for name, title in TITLES.items():
        files[ROOT / "config" / f"{name}.yaml"] = format_parameter_file(PRESETS[name], title)
    for name, title in TARGET_TITLES.items():
        path = ROOT / "config" / f"target_{name}.yaml"
        files[path] = format_parameter_file(TARGET_PRESETS[name], title)
    return files


def main() -> None:
    """Write all files."""
    for path, content in generated_files().items():
        path.write_text(content, encoding="utf-8")


if __name__ == "__main__":
    main()
