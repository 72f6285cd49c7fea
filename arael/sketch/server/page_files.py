"""The page's files as browsers receive them: compressed, kept by the browser."""

from __future__ import annotations

import gzip
import hashlib
import os
from functools import lru_cache
from pathlib import Path
from typing import Any

from starlette.datastructures import Headers
from starlette.responses import Response
from starlette.staticfiles import NotModifiedResponse, StaticFiles

_KINDS = {".js": "text/javascript", ".css": "text/css", ".html": "text/html"}


class PageFiles(StaticFiles):
    """Files of a folder; those of `_KINDS` are compressed if the browser reads that.

    A file that the browser has already is not sent again: its `ETag` is that of its content.
    """

    def file_response(
        self, full_path: Any, stat_result: os.stat_result, scope: Any, status_code: int = 200
    ) -> Response:
        """The answer for one file."""
        path = Path(full_path)
        if path.suffix not in _KINDS:
            return super().file_response(full_path, stat_result, scope, status_code)
        plain, compressed, tag = _content(path, stat_result.st_mtime_ns, stat_result.st_size)
        asked = Headers(scope=scope)
        squeezed = "gzip" in asked.get("accept-encoding", "")
        headers = {"etag": tag, "vary": "accept-encoding"}
        if squeezed:
            headers["content-encoding"] = "gzip"
        found = Response(
            compressed if squeezed else plain, status_code, headers, _KINDS[path.suffix]
        )
        return NotModifiedResponse(found.headers) if asked.get("if-none-match") == tag else found


@lru_cache(maxsize=512)
def _content(path: Path, changed: int, size: int) -> tuple[bytes, bytes, str]:
    """Bytes, compressed bytes and tag of a file; computed again once it has changed."""
    del changed, size
    plain = path.read_bytes()
    # weak: one tag for both encodings
    tag = f'W/"{hashlib.sha256(plain).hexdigest()[:20]}"'
    return plain, gzip.compress(plain, 9, mtime=0), tag
