"""A node and a robot as two processes at 500 Hz, in real time, over UDP and a bad link.

python legged_walk.py robot law.json --late 1 --jitter 2 --lost 0.05     # the robot
python legged_walk.py robot --log walk.log        # the node, in another terminal
python legged_walk.py robot --replay walk.log     # the same answers to the bit, or an error"""

import argparse
import select
import socket
import time
from pathlib import Path

from legged_link import COMMAND, JOINTS, PERIOD_S, STATE, Link, count_of, received
from legged_node import Node, replayed
from legged_robot import Robot


def serve(port, robot, seconds, bad):  # the robot: a state out, the newest command in
    there, back, late = Link(1, *bad), Link(2, *bad), 0
    _, node = port.recvfrom(COMMAND.size)  # until it calls
    due = time.monotonic()
    for _ in range(round(seconds / PERIOD_S)):
        port.sendto(there.passed(robot.state()) or robot.state(), node)
        due, came = due + PERIOD_S, [b""]
        while (left := due - time.monotonic()) > 0.0:
            if select.select([port], [], [], left)[0]:
                came.append(received(port, COMMAND))
        late += time.monotonic() > due + PERIOD_S
        robot.step(back.passed(max(came, key=count_of)))
    print(f"{robot.sensed('root_forward'):.2f} m, fell: {robot.fell}; {late} periods began late")


def drive(port, node, log):  # the node: an answer to every state, until there is none
    port.settimeout(1.0)
    port.send(COMMAND.pack(0, 0, *[0.0] * JOINTS))
    try:
        while True:
            if packet := received(port, STATE):
                port.send(command := node.answer(packet))
                log.write(packet + command)
    except (TimeoutError, ConnectionRefusedError):
        print(f"{node.heard} states; stopped: {node.stopped or 'no'}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    usual = {"folder": "robot", "--log": "/dev/null", "--replay": "", "--seconds": 10.0}
    for name, value in (usual | {"--late": 0, "--jitter": 0, "--lost": 0.0}).items():
        parser.add_argument(name, type=type(value), default=value)
    parser.add_argument("law", nargs="?")
    x, here = parser.parse_args(), ("127.0.0.1", 9870)
    with socket.socket(type=socket.SOCK_DGRAM) as port, open(x.log, "wb") as log:
        if x.replay:
            print(replayed(x.folder, Path(x.replay).read_bytes()), "answers, all the same")
        elif x.law:
            port.bind(here)
            serve(port, Robot(x.law, x.folder), x.seconds, (x.late, x.jitter, x.lost))
        else:
            port.connect(here)
            drive(port, Node(x.folder), log)
