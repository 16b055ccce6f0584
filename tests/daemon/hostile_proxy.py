"""Stands between the processes of a cluster, with a certificate of it, and changes what they say: frames are altered, cut, lengthened,
swapped, said twice, said to others, or lie about their length. Each direction of each connection is a thread."""
import collections
import random
import socket
import ssl
import struct
import threading

HEADER = 32  # of a frame: operation, two of padding, flags, length of what follows (4), operation data, source, destination (8 each)
INTERESTING = (b"\x00", b"\xff", b"\x7f", b"\x80", b"\x01", b"\xff\xff\xff\xff", b"\x00\x00\x00\x00", b"\xff" * 8, b"\x7f" + b"\xff" * 7,
               b"\x80\x80\x80\x80\x80\x80\x80\x80\x80\x01", b"\xff\xff\xff\xff\x0f")


class Figures:
    def __init__(self):
        self.frames = self.changed = self.connections = 0
        self.lock = threading.Lock()

    def add(self, **what):
        with self.lock:
            for name, number in what.items():
                setattr(self, name, getattr(self, name) + number)


class Mutator:
    """`names`: pairs of as long byte strings; the first is replaced by the second (a folder by another one)."""

    def __init__(self, seed, share, names):
        self.chance, self.share, self.names = random.Random(seed), share, names
        self.seen = collections.deque(maxlen=400)
        self.on = threading.Event()
        self.lock = threading.Lock()

    def of(self, frame, first):
        """What is sent in place of a frame: a list of byte strings; and whether that is something else."""
        with self.lock:
            self.seen.append(frame)
            # The first frames of a connection are its handshake: mostly they stay, or nothing would follow.
            if not self.on.is_set() or self.chance.random() > (self.share / 10 if first else self.share):
                return [frame], False
            return self.change(frame), True

    def change(self, frame):
        how, c = self.chance.randrange(12), self.chance
        header, payload = bytearray(frame[:HEADER]), bytearray(frame[HEADER:])
        if how == 0:
            return []
        if how == 1:
            return [frame, frame]
        if how == 2:
            return [c.choice(self.seen), frame]
        if how == 3:
            return [frame, *(c.choice(self.seen) for _ in range(c.randrange(1, 30)))]
        if how == 4:  # who is meant, or what for
            at = c.choice((0, 3, *range(8, HEADER)))
            header[at] = c.randrange(256)
        elif how == 5:  # a length that is not so
            header[4:8] = struct.pack(">I", c.choice((0, 1, len(payload) + 1, 1 << 20, 1 << 26, (1 << 26) + 1, 1 << 30, 0xffffffff)))
            return [bytes(header) + bytes(payload)]
        elif how == 6:
            del payload[c.randrange(len(payload) + 1):]
        elif how == 7:
            payload += c.randbytes(c.choice((1, 8, 1000, 100_000)))
        elif how == 8 and self.names:
            old, new = c.choice(self.names)
            payload = payload.replace(old, new)
        elif payload and how == 9:
            what, at = c.choice(INTERESTING), c.randrange(len(payload))
            payload[at:at + len(what)] = what
        else:
            for _ in range(c.choice((1, 1, 2, 8, 64))):
                if payload:
                    payload[c.randrange(len(payload))] = c.randrange(256)
        header[4:8] = struct.pack(">I", len(payload))
        return [bytes(header) + bytes(payload)]


def read_exactly(stream, count):
    parts, left = [], count
    while left > 0:
        part = stream.recv(min(left, 1 << 20))
        if not part:
            raise OSError("the end")
        parts.append(part)
        left -= len(part)
    return b"".join(parts)


class Proxy:
    """Listens at `port` for whoever wants `target`."""

    def __init__(self, port, target, certs, name, mutator, figures):
        self.target, self.mutator, self.figures = target, mutator, figures
        self.server, self.client = (ssl.SSLContext(side) for side in (ssl.PROTOCOL_TLS_SERVER, ssl.PROTOCOL_TLS_CLIENT))
        for context in (self.server, self.client):
            context.check_hostname = False
            context.load_cert_chain(certs / f"{name}.pem", certs / f"{name}.key")
            context.load_verify_locations(certs / "ca.pem")
            context.verify_mode = ssl.CERT_REQUIRED
        self.listener = socket.create_server(("127.0.0.1", port))
        self.open = True
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while self.open:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                return
            threading.Thread(target=self.serve, args=(connection,), daemon=True).start()

    def serve(self, connection):
        try:
            there = self.client.wrap_socket(socket.create_connection(("127.0.0.1", self.target), timeout=20))
            here = self.server.wrap_socket(connection, server_side=True)
        except OSError:
            connection.close()
            return
        for stream in (here, there):
            stream.settimeout(None)
        self.figures.add(connections=1)
        locks = {here: threading.Lock(), there: threading.Lock()}
        for source, sink in ((here, there), (there, here)):
            threading.Thread(target=self.pump, args=(source, sink, locks[sink]), daemon=True).start()

    def pump(self, source, sink, lock):
        frames = 0
        try:
            while True:
                header = read_exactly(source, HEADER)
                frame = header + read_exactly(source, struct.unpack(">I", header[4:8])[0])
                out, changed = self.mutator.of(frame, frames < 3)
                frames += 1
                self.figures.add(frames=1, changed=changed)
                with lock:
                    for one in out:
                        sink.sendall(one)
        except (OSError, ValueError):
            pass
        finally:
            for stream in (source, sink):
                try:
                    stream.shutdown(socket.SHUT_RDWR)
                except OSError:
                    pass
            source.close()

    def end(self):
        self.open = False
        self.listener.close()
