"""The stand-in refuses what Jazzy refuses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

HEAD = """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([{entity}])
"""


def play(jazzy: Any, folder: Path, entity: str, **arguments: str) -> Any:
    path = folder / "some.launch.py"
    path.write_text(HEAD.format(entity=entity))
    return jazzy.run(path, {}, **arguments)


@pytest.mark.parametrize(
    ("entity", "words"),
    [
        (
            'DeclareLaunchArgument("f", default_value=PathJoinSubstitution('
            '["/config", [LaunchConfiguration("preset"), ".yaml"]]))',
            "Failed to normalize given item of type '<class 'list'>'",
        ),
        ('DeclareLaunchArgument("f", default_value=3)', "not iterable"),
        ('DeclareLaunchArgument("f", default_value="a", choices=("a", "b"))', "none of"),
        ('Node(package="p", executable="e", parameters="file.yaml")', "none of"),
        ('Node(package="p", executable="e", parameters=[{"a": None}])', "not iterable"),
        ('"no entity"', "none of"),
    ],
)
def test_wrong_types_and_names_are_refused(
    jazzy: Any, tmp_path: Path, entity: str, words: str
) -> None:
    with pytest.raises(TypeError, match=words):
        play(jazzy, tmp_path, entity)


def test_an_import_that_jazzy_does_not_have_is_refused(jazzy: Any, tmp_path: Path) -> None:
    path = tmp_path / "some.launch.py"
    path.write_text("from launch.substitutions import StringJoinSubstitution\n")
    with pytest.raises(ImportError):
        jazzy.run(path, {})


def test_a_parameter_file_must_be_there(jazzy: Any, tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="is not a file"):
        play(jazzy, tmp_path, 'Node(package="p", executable="e", parameters=["/no/file.yaml"])')


def test_values_of_arguments_are_read_as_yaml(jazzy: Any, tmp_path: Path) -> None:
    entity = (
        'DeclareLaunchArgument("a"), Node(package="p", executable="e",'
        ' parameters=[{"a": LaunchConfiguration("a")}])'
    )
    context = play(jazzy, tmp_path, entity, a="7")
    assert context.started[0].values() == {"a": 7}
