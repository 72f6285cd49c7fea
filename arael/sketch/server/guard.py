"""What a request must have: a local host, no foreign origin, and the token where it counts."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from typing import Any
from urllib.parse import parse_qs

Scope = Any
POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Content security policy of the page: nothing from elsewhere."""

_NO_TOKEN = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>arael sketch: the address is not complete</title>
<style>
  :root { color-scheme: light dark }
  body { max-width: 34rem; margin: 15vh auto; padding: 0 1.5rem; font: 16px/1.5 sans-serif }
  code { padding: 0.1em 0.35em; background: color-mix(in srgb, currentColor 10%, transparent) }
</style>
<h1>This address is not complete</h1>
<p>The sketch is here, but its address ends in <code>?token=...</code>, a secret that keeps other
programs out; it is missing here, or belongs to another sketch.</p>
<p>Copy the whole address from the terminal in which <code>arael sketch --serve</code> runs (it is
printed after <code>open</code>), or run the command again: it opens the right page.</p>
</html>
"""

_HEADERS = [
    (b"content-security-policy", POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cache-control", b"no-cache"),
]


class Guard:
    """ASGI middleware that refuses requests of other hosts and pages.

    The name of the host is checked because a name that leads here (DNS rebinding) makes a foreign
    page one of this server's origin; the origin because browsers let any page open a WebSocket.

    Parameters
    ----------
    app : that is guarded
    tokens : by path, in the query (``token=``) or as ``Authorization: Bearer``; other paths need
        none. Agents and pages have different ones: an agent cannot answer in place of a person
    """

    def __init__(self, app: Any, tokens: Mapping[str, str]) -> None:
        self._app = app
        self._tokens = {path: token.encode() for path, token in tokens.items()}

    async def __call__(self, scope: Scope, receive: Any, send: Any) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if not refusal:
            await self._app(scope, receive, _with_headers(send))
            return
        status, reason = refusal
        if scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 4403, "reason": reason})
            return
        person = status == 401 and scope["path"] == "/"
        body = (_NO_TOKEN if person else f"{reason}\n").encode()
        kind = b"text/html" if person else b"text/plain"
        headers = [(b"content-type", kind + b"; charset=utf-8"), *_HEADERS]
        await send({"type": "http.response.start", "status": status, "headers": headers})
        await send({"type": "http.response.body", "body": body})

    def _refusal(self, scope: Scope) -> tuple[int, str] | None:
        headers: dict[bytes, bytes] = {}
        for name, value in scope["headers"]:
            if name in headers and name in (b"host", b"origin", b"authorization"):
                return 400, f"{name.decode()} is given twice"
            headers[name] = value
        host = headers.get(b"host", b"").decode("latin-1").lower()
        if not _is_local(host):
            return 421, "this server answers to 127.0.0.1 and localhost only"
        origin = headers.get(b"origin")
        if origin is not None and origin.decode("latin-1").lower() != f"http://{host}":
            return 403, "requests of other pages are refused"
        path = f"/{scope['path'].strip('/').partition('/')[0]}"
        if path in self._tokens:
            given = self._given(headers, scope.get("query_string", b""))
            if not secrets.compare_digest(given, self._tokens[path]):
                return 401, "the token is missing or wrong: use the address that was printed"
        elif scope["type"] == "websocket":
            return 404, "there is no WebSocket at this path"
        return None

    @staticmethod
    def _given(headers: dict[bytes, bytes], query: bytes) -> bytes:
        kind, _, value = headers.get(b"authorization", b"").partition(b" ")
        if kind.lower() == b"bearer":
            return value.strip()
        found = parse_qs(query.decode("latin-1")).get("token", [""])
        return found[0].encode() if len(found) == 1 else b""


def _is_local(host: str) -> bool:
    name, colon, port = host.rpartition(":")
    if not colon:
        name, port = host, "80"
    return name in ("127.0.0.1", "localhost") and port.isdigit()


def _with_headers(send: Any) -> Any:
    async def sending(message: Any) -> None:
        if message["type"] == "http.response.start":
            known = {name.lower() for name, _ in message.get("headers", ())}
            added = [one for one in _HEADERS if one[0] not in known]
            message["headers"] = [*message.get("headers", ()), *added]
        await send(message)

    return sending
