"""Start the tracker beside a camera and a controller.

ros2 launch cable_tracker tracker.launch.py image:=/camera/image_raw preset:=default
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node

from launch import LaunchDescription

CONFIG = Path(get_package_share_directory("cable_tracker")) / "config"


def generate_launch_description() -> LaunchDescription:
    arguments = [
        DeclareLaunchArgument("preset", default_value="default", description="default or thesis"),
        DeclareLaunchArgument(
            "params_file",
            default_value=PathJoinSubstitution(
                [str(CONFIG), [LaunchConfiguration("preset"), ".yaml"]]
            ),
            description="YAML file with parameters",
        ),
        DeclareLaunchArgument("namespace", default_value="", description="Namespace of the node"),
        DeclareLaunchArgument("image", default_value="image", description="Topic of the camera"),
        DeclareLaunchArgument(
            "image_transport", default_value="raw", description="raw or compressed"
        ),
    ]
    tracker = Node(
        package="cable_tracker",
        executable="tracker",
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            LaunchConfiguration("params_file"),
            {"image_transport": LaunchConfiguration("image_transport")},
        ],
        remappings=[
            ("image", LaunchConfiguration("image")),
            ("image/compressed", [LaunchConfiguration("image"), "/compressed"]),
        ],
        output="screen",
    )
    return LaunchDescription([*arguments, tracker])
