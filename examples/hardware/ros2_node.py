"""A ROS 2 node: spring forces in, commands out, one step per message.

Run: python ros2_node.py --ros-args -p controller:=leg.native
"""

import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32MultiArray

from tegotae_robots.live import LiveController


class TegotaeNode(Node):
    """Steps the controller when spring forces [N] arrive, and publishes the command of each leg."""

    def __init__(self):
        super().__init__("tegotae")
        path = self.declare_parameter("controller", "leg.native").value
        self.live = LiveController.load(path, clock=self.now_s)
        self.commands = self.create_publisher(Float32MultiArray, "commands", 1)
        self.create_subscription(Float32MultiArray, "spring_force", self.step, 1)

    def now_s(self):
        """The time of ROS [s], which may be simulated."""
        return self.get_clock().now().nanoseconds / 1e9

    def step(self, message):
        """One step, for the time since the last one."""
        command = self.live.step({"spring_force": message.data})
        self.commands.publish(Float32MultiArray(data=command.ravel().tolist()))


def main():
    """Run the node until Ctrl-C."""
    rclpy.init()
    rclpy.spin(TegotaeNode())


if __name__ == "__main__":
    main()
