"""Starts sim_node: ros2 launch rb_physics sim.launch.py scene:=demo record_dir:=recordings"""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription

# name: (default, type of the node's parameter, description)
ARGUMENTS = {
    "scene": ("demo", str, "path of a scene file, or the name of a packaged scene"),
    "record_dir": ("", str, "parent folder of the run's log; empty for no log"),
    "rerun": ("off", str, "off, file or live"),
    "real_time_factor": ("1.0", float, "simulated per wall time; 0 for as fast as possible"),
    "lockstep": ("false", bool, "advance only by ~/step or when every wrench source delivered"),
    "start_paused": ("false", bool, "start paused"),
    "duration": ("0.0", float, "simulated seconds to run; 0 until stopped"),
    "topics": ("", str, "path of another topics.yaml; empty for the packaged one"),
}


def generate_launch_description() -> LaunchDescription:
    """The node with its main parameters, and its namespace, as launch arguments."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, _, description) in ARGUMENTS.items()
    ]
    arguments.append(
        DeclareLaunchArgument("namespace", default_value="", description="namespace of the node")
    )
    node = Node(
        package="rb_physics",
        executable="sim_node",
        name="sim_node",
        namespace=LaunchConfiguration("namespace"),
        output="screen",
        parameters=[
            {
                name: ParameterValue(LaunchConfiguration(name), value_type=kind)
                for name, (_, kind, _) in ARGUMENTS.items()
            }
        ],
    )
    return LaunchDescription([*arguments, node])
