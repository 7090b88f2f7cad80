"""A robot with legs and its node behind two UDP ports, at 500 Hz in real time."""

import contextlib
import select
import time

from legged_link import CALL, COMMAND, PERIOD_S, STATE, Link, count_of

SILENT_S = 1.0  # without a new state, after which the node ends


def serve(port, robot, seconds, bad):
    """The robot: a state out, the newest command in; who calls first is its node."""
    outward, back, late, call = Link(1, *bad), Link(2, *bad), 0, b""
    while call != CALL:
        call, node = port.recvfrom(COMMAND.size + 1)
    due = time.monotonic()
    for _ in range(round(seconds / PERIOD_S)):
        port.sendto(outward.passed(robot.state()) or robot.state(), node)
        due, newest = due + PERIOD_S, b""
        while (remaining_s := due - time.monotonic()) > 0.0:
            if select.select([port], [], [], remaining_s)[0]:
                came, sender = port.recvfrom(COMMAND.size + 1)
                if sender == node and robot.accepts(came):  # who called, and no one else
                    newest = max(newest, came, key=count_of)
        late += time.monotonic() > due + PERIOD_S
        robot.step(back.passed(newest))
    print(f"{robot.sensed('root_forward'):.2f} m, fell: {robot.fell}; {late} periods began late")


def drive(port, node, log):
    """The node: an answer to every state, until there is no new one."""
    port.settimeout(SILENT_S)
    port.send(CALL)
    heard, end = -1, 0.0
    with contextlib.suppress(TimeoutError, ConnectionRefusedError):
        while node.heard > heard or time.monotonic() < end:
            if node.heard > heard:
                heard, end = node.heard, time.monotonic() + SILENT_S
            packet = port.recv(STATE.size + 1)
            if len(packet) == STATE.size and (command := node.answer(packet)):
                port.send(command)
                log.write(packet + command)
    print(f"{node.heard} states; stopped: {node.stopped or 'no'}")
