"""The bytes: those of the vectors, and whatever else may come."""

from __future__ import annotations

import random

import pytest
from lafet import Request, codec


def test_a_frame_there_and_back() -> None:
    requests = [Request.move_to("Horizontal", 1200), Request.stop("All")]
    wire = codec.encode(requests, to=7, sender=130)
    (frame,) = codec.decode(b"noise" + wire + wire[:5])
    assert (frame.to, frame.sender, frame.end) == (7, 130, 5 + len(wire))
    assert [record.request() for record in frame.records] == ["Move Horizontal 1200", "Stop All"]
    with pytest.raises(ValueError, match="bytes of requests"):
        codec.encode(requests * 100)


def test_every_request_says_what_it_is() -> None:
    for request, words in [
        (Request.open("Valve1"), "Open Valve1"),
        (Request.lockout(True), "Lockout All on"),
        (Request.quench((60, -60), (120, 60), 40, 1, 25), "StartQuench Control"),
        (Request.trajectory([(0, 0, 20, 5)], True, False), "StartTrajectory Control"),
        (Request.seek((0, 600), (-300, 0), True), "StartSeek Detector"),
        (Request.parse("move vertical 60"), "Move Vertical 60"),
    ]:
        (frame,) = codec.decode(codec.encode([request]))
        assert frame.records[0].request().startswith(words)


def test_no_bytes_are_an_error() -> None:
    chance = random.Random(7)
    wire = codec.encode([Request.move_to("Vertical", 60)])
    for _ in range(2000):
        spoilt = bytearray(wire * 2)
        for _ in range(chance.randrange(4)):
            spoilt[chance.randrange(len(spoilt))] = chance.randrange(256)
        for frame in codec.decode(bytes(spoilt[chance.randrange(4) :])):
            for record in frame.records:
                assert record.request()
                assert record.answer().fields() is not None
