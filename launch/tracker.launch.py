"""Start the tracker beside a camera and a controller.

ros2 launch cable_tracker tracker.launch.py image:=/camera/image_raw preset:=default
"""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

INSTRUMENTS = ("camera_info", "altitude", "imu", "odometry")


def arguments() -> list[DeclareLaunchArgument]:
    """Return what may be given on the command line."""
    return [
        DeclareLaunchArgument(
            "preset", default_value="default", description="Values that the parameters start from"
        ),
        DeclareLaunchArgument(
            "params_file",
            default_value=[
                FindPackageShare("cable_tracker"),
                "/config/",
                LaunchConfiguration("preset"),
                ".yaml",
            ],
            description="YAML file with parameters; what it sets counts",
        ),
        DeclareLaunchArgument(
            "vehicle_file",
            default_value=LaunchConfiguration("params_file"),
            description="YAML file with parameters of the vehicle alone, as its mounting, under the"
            " same name of the node as those of params_file",
        ),
        DeclareLaunchArgument("namespace", default_value="", description="Namespace of the node"),
        DeclareLaunchArgument("image", default_value="image", description="Topic of the camera"),
        DeclareLaunchArgument(
            "image_transport",
            default_value="raw",
            description="Read the topic itself, or what is compressed beside it",
            choices=["raw", "compressed"],
        ),
        DeclareLaunchArgument(
            "image_reliability",
            default_value="best_effort",
            description="Take the newest frame, or every frame of a reliable camera",
            choices=["best_effort", "reliable"],
        ),
        DeclareLaunchArgument(
            "instrument_reliability",
            default_value="best_effort",
            description="Take the newest messages of the instruments, or all of reliable ones",
            choices=["best_effort", "reliable"],
        ),
        DeclareLaunchArgument(
            "instrument_wait",
            default_value="0.0",
            description="Longest time that a frame waits for the instruments [s]",
        ),
        *(
            DeclareLaunchArgument(name, default_value=name, description=f"Topic of {name}")
            for name in INSTRUMENTS
        ),
        DeclareLaunchArgument(
            "use_sim_time", default_value="false", description="Take the time from /clock"
        ),
        DeclareLaunchArgument(
            "log_level", default_value="info", description="debug, info, warn, error or fatal"
        ),
    ]


def tracker() -> Node:
    """Return the tracker, with its parameters and topics."""
    words = ("preset", "image_transport", "image_reliability", "instrument_reliability")
    wait = ParameterValue(LaunchConfiguration("instrument_wait"), value_type=float)
    return Node(
        package="cable_tracker",
        executable="tracker",
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            {name: ParameterValue(LaunchConfiguration(name), value_type=str) for name in words},
            {"use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)},
            {"instrument_wait": wait},
            LaunchConfiguration("params_file"),
            LaunchConfiguration("vehicle_file"),
        ],
        remappings=[
            ("image", LaunchConfiguration("image")),
            ("image/compressed", [LaunchConfiguration("image"), "/compressed"]),
            *((name, LaunchConfiguration(name)) for name in INSTRUMENTS),
        ],
        ros_arguments=["--log-level", LaunchConfiguration("log_level")],
        output="screen",
    )


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription([*arguments(), tracker()])
