"""The rows of the ablation: trackers that differ in one part from `default`, or from each other.

Values that are not switched off here are taken from the presets, so that the rows follow them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import ParameterError
from cable_tracker.tracking.parameter_table import ParameterValue, check_name

DEFAULT, THESIS = "default", "thesis"

VARIANCES = (
    "distance_variance", "angle_variance", "width_variance", "skew_variance",
    "distance_rate_variance", "angle_rate_variance", "width_rate_variance", "skew_rate_variance",
)  # fmt: skip

RANDOM_START = (
    "width_minimum", "initial_distance_range", "initial_angle_range", "initial_width_minimum",
    "initial_width_maximum", "initial_skew_minimum", "initial_skew_maximum",
    "initial_distance_rate_range", "initial_angle_rate_range",
)  # fmt: skip

CLAIMS = (
    "evidence_to_track",
    "evidence_to_find",
    "evidence_to_lose",
    "confirmation_time",
    "loss_time",
)

EVIDENCE_IN_FULL: Mapping[str, ParameterValue] = MappingProxyType(
    {"evidence_repeated": 1.0, "evidence_limit": 1e6, "evidence_limit_known": 1e6}
)
ANY_WIDTH: Mapping[str, ParameterValue] = MappingProxyType({"width_spread": 100.0})
NO_DETECTOR: Mapping[str, ParameterValue] = MappingProxyType({"detector": "none"})
NO_NETWORK: Mapping[str, ParameterValue] = MappingProxyType({"looks": "borders"})
NO_REFINEMENT: Mapping[str, ParameterValue] = MappingProxyType({"refinement_rounds": 0})


@dataclass(frozen=True, slots=True)
class AblationRow:
    """A tracker of the ablation.

    Attributes
    ----------
    name : str
        Name in tables and on the command line.
    description : str
        Difference from the base, in a few words.
    base : str
        Preset that the changes are made to.
    changes : mapping of str to ParameterValue
        By parameter.
    compared_to : str
        Name of the row that its loss is compared with; empty for the first of a table.
    """

    name: str
    description: str
    base: str
    changes: Mapping[str, ParameterValue]
    compared_to: str

    def parameters(self) -> TrackerParameters:
        """Return all parameters.

        Raises
        ------
        ParameterError
            The changes are not possible.
        """
        return preset(self.base).replaced(self.changes)


@dataclass(frozen=True, slots=True)
class AblationTable:
    """Rows that belong together.

    Attributes
    ----------
    title : str
        Title of the table.
    file_name : str
        Name of the CSV file.
    rows : tuple of AblationRow
        In order.
    """

    title: str
    file_name: str
    rows: tuple[AblationRow, ...]


def _values(source: str, names: Sequence[str]) -> dict[str, ParameterValue]:
    """Return parameters of a preset."""
    values = preset(source).as_mapping()
    return {name: values[name] for name in names}


def _without(name: str, description: str, changes: Mapping[str, ParameterValue]) -> AblationRow:
    return AblationRow(name, description, DEFAULT, changes, DEFAULT)


TAKEN_AWAY = AblationTable(
    "Taken away: `default` with one part changed back",
    "taken_away.csv",
    (
        AblationRow(DEFAULT, "the preset", DEFAULT, MappingProxyType({}), ""),
        _without("no_detector", "no detector proposes cables", NO_DETECTOR),
        _without("no_network", "no network says where a cable may be", NO_NETWORK),
        _without(
            "map_where_faint",
            "the network looks at a known cable only where a border of it is faint",
            {"map_interval": 3600.0},
        ),
        _without("borders_width", "the width is that of the borders", {"map_width_share": 0.0}),
        _without("no_refinement", "no particles drawn anew in the same frame", NO_REFINEMENT),
        _without("gaussian", "Gaussian diffusion", {"diffusion_degrees_of_freedom": 0.0}),
        _without(
            "constant_shape",
            "no rates of w and β",
            {"width_rate_variance": 0.0, "skew_rate_variance": 0.0},
        ),
        _without("uneven_light", "uneven light left in", {"light_correction": 0.0}),
        _without("burned_in", "lines of a survey display left in", {"burned_in_time": 0.0}),
        _without("free_outside", "points outside the image cost nothing", {"missing_cost": 0.0}),
        _without("no_bands", "no cable changes between bright and dark", {"reversal_cost": 1e3}),
        _without("no_covered_ends", "no end of a cable is covered", {"covered_cost": 1e3}),
        _without("hardly_tempered", "points of a border all but independent", {"tempering": 0.3}),
        _without("any_width", "no usual width", ANY_WIDTH),
        _without("evidence_in_full", "evidence counts in full every frame", EVIDENCE_IN_FULL),
        _without(
            "never_known", "a known cable counts as any other", {"evidence_limit_known": 18.0}
        ),
        _without(
            "fixtures_kept",
            "what is fixed to the vehicle is followed, too",
            {"fixture_travel": 0.0},
        ),
        _without("no_polarity", "bright or dark not remembered", {"polarity_memory": 0.0}),
        _without("undamped", "undamped rates, as in the thesis", {"rate_damping": 1.0}),
        _without(
            "thesis_variances",
            "variances of the diffusion as in the thesis",
            _values(THESIS, VARIANCES),
        ),
        _without("particles_2000", "2000 particles", {"particle_count": 2000}),
        _without("particles_200", "200 particles", {"particle_count": 200}),
    ),
)


@dataclass(frozen=True, slots=True)
class _Step:
    """Parameters that a row takes from `default`, and those it switches off until a later row."""

    name: str
    description: str
    taken: tuple[str, ...]
    switched_off: Mapping[str, ParameterValue] = field(default_factory=dict)


_STEPS = (
    _Step(
        "systematic",
        "systematic resampling, reflection at the limits",
        ("resampling", "limit_handling"),
    ),
    _Step(
        "diffusion",
        "variances of `default`, damped rates",
        (*VARIANCES, "rate_damping"),
    ),
    _Step("light", "uneven light taken out", ("light_correction",)),
    _Step("display", "lines of a survey display taken out", ("burned_in_time",)),
    _Step("spacing", "points as near to each other as in `default`", ("sample_spacing",)),
    _Step(
        "likelihood_ratio",
        "learnt ratios instead of sums of responses, with the claims that go with them",
        ("observation", *CLAIMS),
    ),
    _Step("student_t", "heavy tails of the diffusion", ("diffusion_degrees_of_freedom",)),
    _Step(
        "multi_hypothesis",
        "the filter of several hypotheses with births everywhere, but none of what follows",
        ("filter", "width_maximum", "skew_limit", *RANDOM_START),
        MappingProxyType(
            {**NO_DETECTOR, **NO_NETWORK, **NO_REFINEMENT, **ANY_WIDTH, **EVIDENCE_IN_FULL}
        ),
    ),
    _Step("refinement", "particles drawn anew in the same frame", tuple(NO_REFINEMENT)),
    _Step(
        "evidence",
        "usual width, and evidence that does not count in full every frame",
        (*ANY_WIDTH, *EVIDENCE_IN_FULL),
    ),
    _Step("detector", "a detector proposes cables", tuple(NO_DETECTOR)),
    _Step(DEFAULT, "a network says where a cable may be", tuple(NO_NETWORK)),
)


def _built_up() -> tuple[AblationRow, ...]:
    rows = [AblationRow(THESIS, "the preset", THESIS, MappingProxyType({}), "")]
    for step in _STEPS:
        before = rows[-1]
        changes = {**before.changes, **_values(DEFAULT, step.taken), **step.switched_off}
        rows.append(AblationRow(step.name, step.description, THESIS, changes, before.name))
    return tuple(rows)


BUILT_UP = AblationTable(
    "Built up: from `thesis` to `default`, each row with all those above it",
    "built_up.csv",
    _built_up(),
)

ABLATION_TABLES = (TAKEN_AWAY, BUILT_UP)

ROW_NAMES = tuple(dict.fromkeys(row.name for table in ABLATION_TABLES for row in table.rows))
"""Names of all rows; `default` stands in both tables, with equal parameters."""


def check_row_names(names: Sequence[str]) -> None:
    """See that there are such rows, at least one.

    Raises
    ------
    ParameterError
        There is no such row, or none is named.
    """
    if not names:
        raise ParameterError(f"row: give at least one of {' | '.join(ROW_NAMES)}")
    for name in names:
        check_name("row", name, ROW_NAMES)
