"""uvicorn's WebSocket with a short way for places of the pointer, and frames that answer them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.exceptions import InvalidState

EXTENSION = "arael.socket"
"""Name of the extension in the scope of a connection that is the connection itself."""


class QuickSocket(WebSocketsSansIOProtocol):
    """A connection that gives messages to a function as soon as they are read, if it takes them.

    An application gets its messages from a queue, by a task of its own, and sends by another one:
    of a frame of a drag of 500 constraints that is 15 % of the server's processor time. Everything
    that WebSockets require is done by the library all the same.

    The application finds this object in the scope, as the extension `EXTENSION`.

    Attributes
    ----------
    takes : given a binary message if nothing that came before it waits, and at most once for what
        is read at once; whether it has dealt with it
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.takes: Callable[[bytes], bool] | None = None
        self._may_take = True

    def handle_connect(self, event: Any) -> None:
        """As the library does; the scope names this object."""
        super().handle_connect(event)
        if hasattr(self, "scope"):  # accepted
            cast(Any, self.scope)["extensions"][EXTENSION] = self

    def data_received(self, data: bytes) -> None:
        """As the library does."""
        self._may_take = True
        super().data_received(data)

    def handle_bytes(self, event: Any) -> None:
        """Give a message to `takes`, or put it in the application's queue."""
        if self.takes is not None and self._may_take and event.fin and self.queue.empty():
            self._may_take = False
            if self.takes(event.data):
                return
        super().handle_bytes(event)

    def send_now(self, data: bytes) -> bool:
        """Send a binary message, if nothing waits to be sent; whether it was."""
        if self.close_sent or self.transport.is_closing() or not self.writable.is_set():
            return False
        try:
            self.conn.send_binary(data)
        except InvalidState:  # closed by the page
            return False
        self.transport.write(b"".join(self.conn.data_to_send()))
        return True
