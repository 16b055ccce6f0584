"""A switch for network namespaces, which holds every frame and loses some: what `tc netem` does, where the kernel has it.
slow_switch.py DELAY_MS SHARE_LOST: to the namespace of each process whose number is on its input it gives a device eth0, and says so by a line."""
import collections
import ctypes
import fcntl
import os
import random
import selectors
import struct
import sys
import time

CLONE_NEWNET, TUNSETIFF, IFF_TAP, IFF_NO_PI = 0x40000000, 0x400454CA, 0x0002, 0x1000
FRAME_MAX = 1 << 16
MANY = 64  # frames of one port that are taken at once
LIBC = ctypes.CDLL(None, use_errno=True)


def enter(namespace):
    if LIBC.setns(namespace, CLONE_NEWNET) != 0:
        raise OSError(ctypes.get_errno(), "setns")


def port(process):
    """Where the frames are that go out of its eth0, and into it. The device ends with this process."""
    own, there = os.open("/proc/self/ns/net", os.O_RDONLY), os.open(f"/proc/{process}/ns/net", os.O_RDONLY)
    enter(there)
    try:
        tap = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
        fcntl.ioctl(tap, TUNSETIFF, struct.pack("16sH14x", b"eth0", IFF_TAP | IFF_NO_PI))
    finally:
        enter(own)
        os.close(own)
        os.close(there)
    return tap


class Switch:
    def __init__(self, delay_s, lost):
        self.delay_s, self.lost = delay_s, lost
        self.ports, self.known = [], {}  # by address of Ethernet
        self.held = collections.deque()  # (when it is due, where it came from, frame)

    def take(self, tap):
        for _ in range(MANY):
            try:
                frame = os.read(tap, FRAME_MAX)
            except OSError:  # none, or the namespace is about to go
                return
            self.known[frame[6:12]] = tap
            if random.random() >= self.lost:
                self.held.append((time.monotonic() + self.delay_s, tap, frame))

    def pass_on(self):
        """What is due. Returns how long it is until the next."""
        while self.held:
            due, came_from, frame = self.held[0]
            if (left := due - time.monotonic()) > 0:
                return left
            self.held.popleft()
            to = self.known.get(frame[:6])
            for tap in [to] if to else [tap for tap in self.ports if tap != came_from]:
                try:
                    os.write(tap, frame)
                except OSError:
                    pass  # its queue is full, or it is down: a frame is lost
        return None


def main():
    switch = Switch(float(sys.argv[1]) / 1000, float(sys.argv[2]))
    with selectors.DefaultSelector() as ready:
        ready.register(sys.stdin, selectors.EVENT_READ)
        while True:
            for key, _ in ready.select(switch.pass_on()):
                if key.fileobj is not sys.stdin:
                    switch.take(key.fileobj)
                    continue
                process = sys.stdin.readline().strip()
                if not process:
                    return
                switch.ports.append(port(process))
                ready.register(switch.ports[-1], selectors.EVENT_READ)
                print(process, flush=True)


if __name__ == "__main__":
    main()
