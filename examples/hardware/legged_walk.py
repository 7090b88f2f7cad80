"""A node and a robot as two processes at 500 Hz, in real time, over UDP and a bad link.

python legged_walk.py robot law.json --late 1 --jitter 2 --lost 0.05     # the robot
python legged_walk.py robot --log walk.log        # the node, in another terminal
python legged_walk.py robot --replay walk.log     # the same answers to the bit, or an error"""

import argparse
import socket
from pathlib import Path

from legged_node import Node, replayed
from legged_ports import drive, serve
from legged_robot import Robot

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    defaults = {"folder": "robot", "--log": "/dev/null", "--replay": "", "--port": 9870}
    defaults |= {"--seconds": 10.0, "--late": 0, "--jitter": 0, "--lost": 0.0}
    for name, value in defaults.items():
        parser.add_argument(name, type=type(value), default=value)
    parser.add_argument("law", nargs="?")
    x = parser.parse_args()
    address = "127.0.0.1", x.port
    for file in filter(None, (x.folder, x.law, x.replay)):
        if not Path(file).exists():
            parser.error(f"there is no {file}; name the folder of the exported C, and files")
    with socket.socket(type=socket.SOCK_DGRAM) as port, open(x.log, "wb") as log:
        if x.replay:
            print(replayed(x.folder, Path(x.replay).read_bytes()), "answers, all the same")
        elif x.law:
            port.bind(address)
            serve(port, Robot(x.law, x.folder), x.seconds, (x.late, x.jitter, x.lost))
        else:
            port.connect(address)
            drive(port, Node(x.folder), log)
