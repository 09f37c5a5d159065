"""What can go wrong. Every message says what, where and what to do; see `lafet.set_language`."""

from __future__ import annotations

__all__ = [
    "Error",
    "LinkLost",
    "NoAnswer",
    "NotReached",
    "NotSent",
    "OutcomeUnknown",
    "ProtocolError",
    "Refused",
    "UsageError",
]


class Error(Exception):
    """Base of all errors of lafet."""


class Refused(Error):
    """The monitor refused the request.

    `request` and `to` are what was asked of whom, `status` is the answer (document, section 2), `by` the
    subsystem that refused: the addressee, or one that intercepted the request.
    """

    def __init__(self, text: str, request: str, to: str, status: str, by: str) -> None:
        super().__init__(text)
        self.request = request
        self.to = to
        self.status = status
        self.by = by

    def __reduce__(self) -> tuple[type[Refused], tuple[str, str, str, str, str]]:
        return type(self), (str(self), self.request, self.to, self.status, self.by)


class NoAnswer(Error):
    """No answer to a request that changes nothing, or no monitor."""


class OutcomeUnknown(Error):
    """The request was sent; whether it was executed is not known."""


class NotSent(Error):
    """The request was not sent, so it is certainly not executed."""


class LinkLost(Error):
    """There is no connection."""


class ProtocolError(Error):
    """An answer that breaks the protocol."""


class UsageError(Error, ValueError):
    """Something that cannot be sent: a wrong URL, an impossible address, too much data."""


class NotReached(Error, TimeoutError):
    """What was waited for did not come in time, or cannot come any more."""
