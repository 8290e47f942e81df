"""Let a simulated vehicle follow a cable by what the tracker says, in real time.

ros2 launch cable_tracker loop.launch.py seed:=3 length:=20.0
"""

from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    IncludeLaunchDescription,
    RegisterEventHandler,
)
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

SHARE = FindPackageShare("cable_tracker")
PASSED_ON = ("preset", "params_file", "namespace", "use_sim_time", "log_level")


def of_type(name: str, value_type: type) -> ParameterValue:
    """Return an argument as the value of a parameter."""
    return ParameterValue(LaunchConfiguration(name), value_type=value_type)


def arguments() -> list[DeclareLaunchArgument]:
    """Return what may be given on the command line."""
    return [
        DeclareLaunchArgument("seed", default_value="0", description="Of world and errors"),
        DeclareLaunchArgument("length", default_value="100.0", description="Of the cable [m]"),
        DeclareLaunchArgument("buried", default_value="5.0", description="Of it under sand [m]"),
        DeclareLaunchArgument("preset", default_value="default", description="Of the tracker"),
        DeclareLaunchArgument(
            "params_file",
            default_value=PathJoinSubstitution([SHARE, "config", "loop.yaml"]),
            description="Parameters of the three nodes, the camera's mounting among them",
        ),
        DeclareLaunchArgument("namespace", default_value="", description="Of the three nodes"),
        DeclareLaunchArgument(
            "use_sim_time", default_value="false", description="Use the simulator's time on /clock"
        ),
        DeclareLaunchArgument(
            "log_level", default_value="info", description="debug, info, warn, error or fatal"
        ),
    ]


def tracker() -> IncludeLaunchDescription:
    """Return the tracker, as its own launch file starts it."""
    return IncludeLaunchDescription(
        PythonLaunchDescriptionSource(PathJoinSubstitution([SHARE, "launch", "tracker.launch.py"])),
        launch_arguments=[(name, LaunchConfiguration(name)) for name in PASSED_ON],
    )


def simulator() -> Node:
    """Return the vehicle with its camera and instruments."""
    return Node(
        package="cable_tracker",
        executable="simulator",
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            {
                "seed": of_type("seed", int),
                "length": of_type("length", float),
                "buried": of_type("buried", float),
                "publish_clock": of_type("use_sim_time", bool),
            },
            LaunchConfiguration("params_file"),
        ],
        ros_arguments=["--log-level", LaunchConfiguration("log_level")],
        output="screen",
    )


def controller() -> Node:
    """Return the example of a controller."""
    return Node(
        package="cable_tracker",
        executable="controller",
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            {"use_sim_time": of_type("use_sim_time", bool)},
            LaunchConfiguration("params_file"),
        ],
        ros_arguments=["--log-level", LaunchConfiguration("log_level")],
        output="screen",
    )


def generate_launch_description() -> LaunchDescription:
    # Whichever of the three ends: the others would wait for it for ever.
    end_together = RegisterEventHandler(OnProcessExit(on_exit=[EmitEvent(event=Shutdown())]))
    return LaunchDescription([*arguments(), tracker(), controller(), simulator(), end_together])
