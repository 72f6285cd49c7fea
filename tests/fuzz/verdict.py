"""Requirements on an error: a code, a message in the common form, an existing place."""

from __future__ import annotations

import re

from arael.diagnostics.as_json import as_json
from arael.diagnostics.records import AraelError
from arael.diagnostics.render import render

CODE = re.compile(r"[EW]\d{4}")
MOST_DIAGNOSTICS = 100
MOST_TEXT = 100_000


def unusable(error: AraelError) -> str:
    """Why a user could not work with `error`; the empty string if nothing is wrong with it."""
    if not 1 <= len(error.diagnostics) <= MOST_DIAGNOSTICS:
        return f"{len(error.diagnostics)} diagnostics"
    for one in error.diagnostics:
        if not CODE.fullmatch(one.code):
            return f"no code: {one}"
        if not one.message or (one.message.endswith(".") and not one.message.endswith("...")):
            return f"not a message: {one}"
        if "internal error" in one.message or "fault of arael" in one.message:
            return f"reported as arael's own fault: {one}"
        if one.span is None and not one.origin:
            return f"no place: {one}"
        spans = [one.span, *(label.span for label in one.labels)]
        for span in spans:
            if span is not None and not 0 <= span.start <= span.end <= len(span.source.text):
                return f"a place outside the text: {one}"
    text = render(error.diagnostics, color=False, width=100)
    as_json(error.diagnostics)
    if not text.strip() or not str(error).strip():
        return "nothing is shown"
    if len(text) > MOST_TEXT:
        return f"{len(text)} characters of messages"
    return ""
