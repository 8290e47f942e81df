"""Replay a recording to the tracker, at its own pace or in lockstep.

ros2 launch cable_tracker replay.launch.py source:=/data/dive image_transport:=raw
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
from launch.substitutions import (
    EqualsSubstitution,
    IfElseSubstitution,
    LaunchConfiguration,
    PathJoinSubstitution,
)
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

SHARE = FindPackageShare("cable_tracker")
PASSED_ON = (
    "preset",
    "params_file",
    "namespace",
    "image",
    "image_transport",
    "image_reliability",
    "instrument_reliability",
    "instrument_wait",
    "use_sim_time",
    "log_level",
)


def of_type(name: str, value_type: type) -> ParameterValue:
    """Return an argument as the value of a parameter."""
    return ParameterValue(LaunchConfiguration(name), value_type=value_type)


def arguments() -> list[DeclareLaunchArgument]:
    """Return what may be given on the command line."""
    return [
        DeclareLaunchArgument("source", description="Bag, video, image folder or sequence file"),
        DeclareLaunchArgument(
            "topic", default_value="", description="Image topic of a bag that has several"
        ),
        DeclareLaunchArgument("rate", default_value="1.0", description="Speed"),
        DeclareLaunchArgument("loop", default_value="false", description="Begin again at the end"),
        DeclareLaunchArgument(
            "lockstep", default_value="false", description="Wait for the tracker at every frame"
        ),
        DeclareLaunchArgument("preset", default_value="default", description="Of the tracker"),
        DeclareLaunchArgument(
            "params_file",
            default_value=[SHARE, "/config/", LaunchConfiguration("preset"), ".yaml"],
            description="YAML file with parameters of the tracker",
        ),
        DeclareLaunchArgument(
            "vehicle",
            default_value="",
            description="vehicle.yaml for both nodes, its values under /** and ros__parameters;"
            " without it the replay reads that of the bag, and the tracker none",
        ),
        DeclareLaunchArgument("namespace", default_value="", description="Of both nodes"),
        DeclareLaunchArgument("image", default_value="image", description="Topic between them"),
        DeclareLaunchArgument(
            "image_transport",
            default_value="raw",
            description="compressed for a recording of compressed images",
            choices=["raw", "compressed"],
        ),
        DeclareLaunchArgument(
            "image_reliability",
            default_value=IfElseSubstitution(
                LaunchConfiguration("lockstep"), if_value="reliable", else_value="best_effort"
            ),
            description="best_effort or reliable; in lockstep no frame may be lost",
        ),
        DeclareLaunchArgument(
            "instrument_reliability",
            default_value=IfElseSubstitution(
                LaunchConfiguration("lockstep"), if_value="reliable", else_value="best_effort"
            ),
            description="best_effort or reliable; in lockstep no message may be lost",
        ),
        DeclareLaunchArgument(
            "instrument_wait",
            default_value=IfElseSubstitution(
                LaunchConfiguration("lockstep"), if_value="1.0", else_value="0.0"
            ),
            description="Longest time that a frame waits for the instruments [s]",
        ),
        DeclareLaunchArgument(
            "use_sim_time",
            default_value="false",
            description="Publish the recording's times on /clock, and let the tracker use them",
        ),
        DeclareLaunchArgument(
            "log_level", default_value="info", description="debug, info, warn, error or fatal"
        ),
    ]


def tracker() -> IncludeLaunchDescription:
    """Return the tracker, as its own launch file starts it."""
    vehicle_file = IfElseSubstitution(
        EqualsSubstitution(LaunchConfiguration("vehicle"), ""),
        if_value=LaunchConfiguration("params_file"),
        else_value=LaunchConfiguration("vehicle"),
    )
    return IncludeLaunchDescription(
        PythonLaunchDescriptionSource(
            PathJoinSubstitution([SHARE, "launch", "tracker.launch.py"]),
        ),
        launch_arguments=[
            *((name, LaunchConfiguration(name)) for name in PASSED_ON),
            ("vehicle_file", vehicle_file),
        ],
    )


def replay() -> Node:
    """Return the node that sends the recording."""
    return Node(
        package="cable_tracker",
        executable="replay",
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            {
                "source": of_type("source", str),
                "topic": of_type("topic", str),
                "vehicle": of_type("vehicle", str),
                "rate": of_type("rate", float),
                "loop": of_type("loop", bool),
                "lockstep": of_type("lockstep", bool),
                "publish_clock": of_type("use_sim_time", bool),
            }
        ],
        remappings=[
            ("image", LaunchConfiguration("image")),
            ("image/compressed", [LaunchConfiguration("image"), "/compressed"]),
        ],
        ros_arguments=["--log-level", LaunchConfiguration("log_level")],
        output="screen",
    )


def generate_launch_description() -> LaunchDescription:
    # Whichever ends: without the tracker the replay would wait for it for ever.
    end_together = RegisterEventHandler(OnProcessExit(on_exit=[EmitEvent(event=Shutdown())]))
    return LaunchDescription([*arguments(), tracker(), replay(), end_together])
