"""The bytes on the wire: frames with requests, and the frames in a stream of bytes."""

from __future__ import annotations

from ._native import Frame, Record, Request, decode, encode

__all__ = ["Frame", "Record", "Request", "decode", "encode"]
