"""Every station of a line, and its coordinator, each as a process of its own.

ros2 launch linewright line.launch.py line:=/path/to/line-directory
ros2 launch linewright line.launch.py line:=… plant:=true          (with simulated devices)
ros2 launch linewright line.launch.py line:=… plant:=true virtual_bus:=true      (and without CAN in the kernel)
ros2 launch linewright line.launch.py line:=… state_dir:=/srv/linewright         (another place for journals)
ros2 launch linewright line.launch.py line:=… forget:=true                       (no journals; a cell forgets its orders with its coordinator)

ros2 launch linewright line.launch.py line:=… autostart:=false                   (nodes wait for a lifecycle manager)
ros2 launch linewright line.launch.py line:=… parameters:=line.yaml              (a parameter file for all of its nodes)

The stations are read from the description, so a new one needs no change here. Nodes are set up by the description, and by
parameters in what no check rests on; namespace and topics can be remapped as usual.
"""

import os
from pathlib import Path

try:
    import tomllib
except ImportError:  # Python before 3.11
    import tomli as tomllib

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


# Beside ROS's own logs; each line has a directory in it.
STATE_DIR = Path(os.environ.get("ROS_HOME", Path.home() / ".ros")) / "linewright"


def linewright(arguments, **options):
    return Node(package="linewright", executable="linewright", arguments=arguments, output="screen", **options)


def nodes(context):
    line = LaunchConfiguration("line").perform(context)
    bus = LaunchConfiguration("bus").perform(context)
    state_dir = LaunchConfiguration("state_dir").perform(context)
    file = Path(line)
    file = file / "line.toml" if file.is_dir() else file
    description = tomllib.loads(file.read_text(encoding="utf-8"))
    stations = [station["name"] for station in description["station"]]

    virtual = ["--virtual-bus"] if LaunchConfiguration("virtual_bus").perform(context) == "true" else []
    forgets = LaunchConfiguration("forget").perform(context) == "true"
    remember = [] if forgets else ["--state-dir", state_dir or str(STATE_DIR / description["name"])]
    forget = ["--forget"] if forgets else []
    waits = [] if LaunchConfiguration("autostart").perform(context) == "true" else ["--no-autostart"]
    parameters = LaunchConfiguration("parameters").perform(context)
    again = {"respawn": True, "respawn_delay": 1.0, "parameters": [parameters] if parameters else []}
    return [
        linewright(["plant", line, "--bus", bus, *virtual, *remember], condition=IfCondition(LaunchConfiguration("plant"))),
        linewright(["coordinator", line, "--bus", bus, *virtual, *remember, *forget, *waits], **again),
        *[linewright(["station", line, "--station", name, *virtual, *remember, *waits], **again) for name in stations],
    ]


def generate_launch_description():
    return LaunchDescription(
        [
            DeclareLaunchArgument("line", description="the line's directory, or its description file"),
            DeclareLaunchArgument("bus", default_value="vcan0", description="the CAN interface of the line's bus"),
            DeclareLaunchArgument(
                "virtual_bus", default_value="false", description="use a virtual bus where there is no CAN interface"
            ),
            DeclareLaunchArgument("plant", default_value="false", description="simulate the devices"),
            DeclareLaunchArgument(
                "state_dir", default_value="", description="where nodes keep their journals; by default below ROS_HOME"
            ),
            DeclareLaunchArgument(
                "autostart", default_value="true", description="nodes are active at once, else they are to be configured and activated"
            ),
            DeclareLaunchArgument("parameters", default_value="", description="a parameter file for all nodes"),
            DeclareLaunchArgument("forget", default_value="false", description="keep no journals, and of a cell no orders"),
            OpaqueFunction(function=nodes),
        ]
    )
