#!/usr/bin/env python3
"""An independent implementation of the link frame (docs/protocol.md, §L), for tests.

Written from the page alone; it shares nothing with the Rust crates. No packages are needed.

    link.py vectors FILE...          check the golden vectors (conformance/vectors/link.json)
    link.py echo                     lines on standard input: `d HEX…` takes bytes of a stream,
                                     `e [32] DST SRC HEX` makes a frame; one line out for each in
    link.py talk HOST PORT           ask the monitor at this TCP port, and check what it answers
"""

import json
import socket
import sys

END, ESC = 0xC0, 0xDB


def crc16(data):
    """§L/2: reflected 0x8005, initial value 0xFFFF."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return crc.to_bytes(2, "little")


def crc32c(data):
    """§L/7: reflected 0x1EDC6F41, start and end inverted."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0x82F63B78 if crc & 1 else crc >> 1
    return (crc ^ 0xFFFFFFFF).to_bytes(4, "little")


def escaped(body):
    return body.replace(b"\xdb", b"\xdb\xdd").replace(b"\xc0", b"\xdb\xdc")


def encode(dst, src, records, long=False):
    """A frame as it goes on the wire."""
    body = bytes([dst, src]) + records
    if long:
        return b"\xff\xc0\xdb\xde" + escaped(body + crc32c(body)) + b"\xc0"
    return b"\xff\xc0" + escaped(body + crc16(body)) + b"\xc0"


def unescaped(body):
    """The bytes between two C0, or None after a wrong escape (§L/4)."""
    out, it = bytearray(), iter(body)
    for byte in it:
        if byte == ESC:
            byte = {0xDC: END, 0xDD: ESC}.get(next(it, None))
            if byte is None:
                return None
        out.append(byte)
    return bytes(out)


class Decoder:
    """Frames out of a stream, however it is cut."""

    def __init__(self):
        self.body = None

    def push(self, data):
        frames = []
        for byte in data:
            if byte != END:
                if self.body is not None:
                    self.body.append(byte)
                continue
            frame = checked(bytes(self.body)) if self.body is not None else None
            # A C0 that ends a bad frame may also be the start of the next (§L/3).
            self.body = None if frame else bytearray()
            if frame:
                frames.append(frame)
        return frames


def checked(body):
    """(dst, src, records, long) of what stands between two C0, or None."""
    long = body[:2] == b"\xdb\xde"
    size, crc = (4, crc32c) if long else (2, crc16)
    body = unescaped(body[2:] if long else body)
    if body is None or len(body) < 2 + size or len(body) > 2 + 512 + size:
        return None
    head = body[:-size]
    return (head[0], head[1], head[2:], long) if crc(head) == body[-size:] else None


def vectors(paths):
    count = 0
    for path in paths:
        with open(path, encoding="utf-8") as file:
            known = json.load(file)
        for frame in known["frames"]:
            wire = bytes.fromhex(frame["wire"])
            body = bytes.fromhex(frame["body"])
            expected = (body[0], body[1], body[2:])
            got = Decoder().push(wire)
            assert [f[:3] for f in got] == [expected], (frame, got)
            assert encode(*expected, long=got[0][3]) == wire, frame
            count += 1
    assert count > 0, "no vectors"
    print(f"{count} frames: decoded and encoded alike")


def echo():
    decoder = Decoder()
    for line in sys.stdin:
        verb, *words = line.split()
        if verb == "d":
            frames = decoder.push(bytes.fromhex("".join(words)))
            print(" ".join(f"{d},{s},{r.hex()},{32 if l else 16}" for d, s, r, l in frames))
        else:
            long = words[0] == "32" and len(words) > 2 and words.pop(0) == "32"
            records = bytes.fromhex(words[2]) if len(words) > 2 else b""
            print(encode(int(words[0]), int(words[1]), records, long).hex())
        sys.stdout.flush()


def talk(host, port):
    """Probe, read, a command that is refused, several requests in a frame; both forms of frames."""
    stream = socket.create_connection((host, int(port)), timeout=30)
    decoder, waiting = Decoder(), []

    def ask(records, long=False, noise=b""):
        stream.sendall(noise + encode(1, 200, records, long))
        while not waiting:
            data = stream.recv(1024)
            assert data, "the connection has ended"
            waiting.extend(decoder.push(data))
        frame = waiting.pop(0)
        assert frame[:2] == (200, 1) and frame[3] == long, frame
        return frame[2]

    def records_of(payload):
        out = []
        while payload:
            size = payload[3]
            out.append((*payload[:3], payload[4 : 4 + size]))
            payload = payload[4 + size :]
        return out

    for long in (False, True):
        assert ask(b"", long) == b"", "a presence probe"
        status = records_of(ask(bytes.fromhex("d40d0000"), long))
        assert len(status) == 1 and status[0][:3] == (0xD4, 0x0D, 0), status
        assert len(status[0][3]) == 8, "DriveStatus: u32, i16, u8, u8"
        # Wrapped: the deployer intercepts (§3.1); the key of Open is not asked for before that.
        moved = records_of(ask(bytes.fromhex("4d0d0002b004"), long))
        assert moved == [(0x4D, 0xA2, 3, b"")], moved
        both = records_of(ask(bytes.fromhex("d4850000" "d4980000"), long, noise=b"\x00\xc0\x12\xff"))
        assert [record[1] for record in both] == [0x85, 0x98], both
        unknown = records_of(ask(bytes.fromhex("77c20000"), long))
        assert unknown == [(0x77, 0xC2, 7, b"")], unknown
        beds = records_of(ask(bytes.fromhex("9dc80002fe23"), long))
        assert beds == [(0x9D, 0xC8, 0, b"\xfe\x23")], beds
    print("talked to the monitor: 12 frames, all as expected")


if __name__ == "__main__":
    commands = {"vectors": lambda *paths: vectors(paths), "echo": echo, "talk": talk}
    if len(sys.argv) < 2 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]](*sys.argv[2:])
