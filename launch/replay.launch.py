"""Replays a recording: ros2 launch rb_physics replay.launch.py recording:=recordings/RUN"""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription

# name: (default, type of the node's parameter, description)
ARGUMENTS = {
    "recording": ("", str, "folder of the recording"),
    "rate": ("1.0", float, "speed; 0 for as fast as possible"),
    "start": ("0.0", float, "seconds of the recording's time at which to begin"),
    "loop": ("false", bool, "begin again at the end"),
    "paused": ("false", bool, "begin paused"),
    "topics": ("", str, "publish only these, with spaces between"),
    "exclude_topics": ("", str, "publish all but these, with spaces between"),
    "inputs": ("false", bool, "publish the recorded inputs as well"),
}


def generate_launch_description() -> LaunchDescription:
    """The node with its parameters as launch arguments."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, _, description) in ARGUMENTS.items()
    ]
    node = Node(
        package="rb_physics",
        executable="replay_node",
        name="replay_node",
        output="screen",
        parameters=[
            {
                name: ParameterValue(LaunchConfiguration(name), value_type=kind)
                for name, (_, kind, _) in ARGUMENTS.items()
            }
        ],
    )
    return LaunchDescription([*arguments, node])
