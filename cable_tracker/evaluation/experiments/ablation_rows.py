"""The rows of the ablation: trackers that differ from `default` in one part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import ParameterError
from cable_tracker.tracking.parameter_table import ParameterValue, check_name

DEFAULT = "default"

VARIANCES = (
    "distance_variance", "angle_variance", "width_variance", "skew_variance",
    "distance_rate_variance", "angle_rate_variance", "width_rate_variance", "skew_rate_variance",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class AblationRow:
    """A tracker of the ablation.

    Attributes
    ----------
    name : str
        Name in tables and on the command line.
    description : str
        Difference from `default`, in a few words.
    changes : mapping of str to ParameterValue
        By parameter.
    """

    name: str
    description: str
    changes: Mapping[str, ParameterValue]

    def parameters(self) -> TrackerParameters:
        """Return all parameters.

        Raises
        ------
        ParameterError
            The changes are not possible.
        """
        return preset(DEFAULT).replaced(self.changes)


ABLATION_ROWS = (
    AblationRow(DEFAULT, "the preset", {}),
    AblationRow("no_detector", "no detector proposes cables", {"detector": "none"}),
    AblationRow("no_network", "no network says where a cable may be", {"looks": "borders"}),
    AblationRow(
        "map_where_faint",
        "the network looks at a known cable only where a border of it is faint",
        {"map_interval": 3600.0},
    ),
    AblationRow("borders_width", "the width is that of the borders", {"map_width_share": 0.0}),
    AblationRow(
        "no_refinement", "no particles drawn anew in the same frame", {"refinement_rounds": 0}
    ),
    AblationRow("gaussian", "Gaussian diffusion", {"diffusion_degrees_of_freedom": 0.0}),
    AblationRow(
        "constant_shape",
        "no rates of w and β",
        {"width_rate_variance": 0.0, "skew_rate_variance": 0.0},
    ),
    AblationRow("uneven_light", "uneven light left in", {"light_correction": 0.0}),
    AblationRow("burned_in", "lines of a survey display left in", {"burned_in_time": 0.0}),
    AblationRow("free_outside", "points outside the image cost nothing", {"missing_cost": 0.0}),
    AblationRow("no_bands", "no cable changes between bright and dark", {"reversal_cost": 1e3}),
    AblationRow("no_covered_ends", "no end of a cable is covered", {"covered_cost": 1e3}),
    AblationRow("hardly_tempered", "points of a border all but independent", {"tempering": 0.3}),
    AblationRow("any_width", "no usual width", {"width_spread": 100.0}),
    AblationRow(
        "evidence_in_full",
        "evidence counts in full every frame",
        {"evidence_repeated": 1.0, "evidence_limit": 1e6, "evidence_limit_known": 1e6},
    ),
    AblationRow("never_known", "a known cable counts as any other", {"evidence_limit_known": 18.0}),
    AblationRow(
        "fixtures_kept",
        "what is fixed to the vehicle is followed, too",
        {"fixture_travel": 0.0},
    ),
    AblationRow("no_polarity", "bright or dark not remembered", {"polarity_memory": 0.0}),
    AblationRow("undamped", "undamped rates, as in the thesis", {"rate_damping": 1.0}),
    AblationRow(
        "thesis_variances",
        "variances of the diffusion as in the thesis",
        {name: preset("thesis").as_mapping()[name] for name in VARIANCES},
    ),
    AblationRow("particles_2000", "2000 particles", {"particle_count": 2000}),
    AblationRow("particles_200", "200 particles", {"particle_count": 200}),
)

ROW_NAMES = tuple(row.name for row in ABLATION_ROWS)
"""Names of all rows, in order."""


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
