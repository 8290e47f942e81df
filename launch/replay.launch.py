"""Replay a recording through the tracker, with its own timing.

ros2 launch cable_tracker replay.launch.py source:=/data/dive image_transport:=raw
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    IncludeLaunchDescription,
    RegisterEventHandler,
)
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription

LAUNCH = Path(get_package_share_directory("cable_tracker")) / "launch"


def generate_launch_description() -> LaunchDescription:
    arguments = [
        DeclareLaunchArgument("source", description="Bag, video, image folder or sequence file"),
        DeclareLaunchArgument("rate", default_value="1.0", description="Speed"),
        DeclareLaunchArgument("loop", default_value="false", description="Begin again at the end"),
        DeclareLaunchArgument(
            "lockstep", default_value="false", description="Wait for the tracker at every frame"
        ),
    ]
    tracker = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(LAUNCH / "tracker.launch.py"))
    )
    replay = Node(
        package="cable_tracker",
        executable="replay",
        parameters=[
            {
                "source": ParameterValue(LaunchConfiguration("source"), value_type=str),
                "rate": ParameterValue(LaunchConfiguration("rate"), value_type=float),
                "loop": ParameterValue(LaunchConfiguration("loop"), value_type=bool),
                "lockstep": ParameterValue(LaunchConfiguration("lockstep"), value_type=bool),
                "wait_for_tracker": True,
            }
        ],
        output="screen",
    )
    end_with_replay = RegisterEventHandler(
        OnProcessExit(target_action=replay, on_exit=[EmitEvent(event=Shutdown())])
    )
    return LaunchDescription([*arguments, tracker, replay, end_with_replay])
