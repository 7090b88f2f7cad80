"""A leg at the other end of a serial cable that is none: a process behind a pseudo-terminal.

It prints the name of its port, and hops until it is stopped.
"""

import os
import pty
import select
import time
import tty

from serial_leg import ANSWER, REQUEST, Packets, packet


class Leg:
    """The paper's hopper as firmware: 0.1 kg on a damped spring of 5 N/m, and its actuator."""

    WATCHDOG_S = 0.5  # no force without a command for so long

    def __init__(self, now_s):
        self.height_m, self.velocity_m_per_s, self.force_n = 1.2, 0.0, 0.0
        self.now_s = self.heard_s = now_s
        self.packets = Packets(REQUEST)

    @property
    def spring_n(self):
        return max(0.0, 5.0 * (1.0 - self.height_m))  # 0 in flight

    def move(self, now_s):
        """Simulate until now, in steps of 0.1 ms."""
        steps = 1 + round((now_s - self.now_s) / 1e-4)
        dt_s, self.now_s = (now_s - self.now_s) / steps, now_s
        if now_s - self.heard_s > self.WATCHDOG_S:
            self.force_n = 0.0
        for _ in range(steps):
            leg_n = self.spring_n and self.spring_n - 0.2 * self.velocity_m_per_s + self.force_n
            self.velocity_m_per_s += (leg_n / 0.1 - 9.81) * dt_s
            self.height_m += self.velocity_m_per_s * dt_s

    def answer(self, data, now_s):
        """Return the bytes that the leg sends back for those that it receives."""
        self.move(now_s)
        sent = b""
        for number, force_n in self.packets.feed(data):
            self.heard_s = now_s
            if number == 1:
                self.force_n = min(max(force_n, 0.0), 4.0)
            else:
                sent += packet(ANSWER, self.spring_n, self.height_m)
        return sent


if __name__ == "__main__":
    leg_port, user_port = pty.openpty()
    tty.setraw(user_port)
    print(os.ttyname(user_port), flush=True)
    leg = Leg(time.monotonic())
    while True:
        heard = os.read(leg_port, 256) if select.select([leg_port], [], [], 0.01)[0] else b""
        os.write(leg_port, leg.answer(heard, time.monotonic()))
