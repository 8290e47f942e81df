from __future__ import annotations

import ast
import inspect
from pathlib import Path

import cable_tracker.particle_filter as package
from cable_tracker.cable.model.movement import CableMovement
from cable_tracker.cable.thesis.observation import BorderObservation
from cable_tracker.particle_filter.models import MovementModel, ObservationModel


def test_the_models_of_the_cable_have_the_signatures_of_the_protocols():
    for model, protocol, method in (
        (CableMovement, MovementModel, "propagate"),
        (BorderObservation, ObservationModel, "log_likelihoods"),
    ):
        own, wanted = (inspect.signature(getattr(kind, method)) for kind in (model, protocol))
        assert list(own.parameters) == list(wanted.parameters)


def test_the_filter_knows_no_cable_and_no_image():
    for file in Path(package.__path__[0]).glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                allowed = ("cable_tracker.arrays", "cable_tracker.particle_filter")
                module = node.module or ""
                assert module.startswith(allowed) or not module.startswith("cable_tracker"), file
