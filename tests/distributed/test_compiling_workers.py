"""A worker that compiles for others may die, leave, or fail: then the next one is asked."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import pytest

import arael
from arael.distributed import compiled
from tests.optional import needs

pytestmark = needs("Dask")

ABSENT = "tcp://127.0.0.1:1"


def dies(code: str, name: str) -> None:
    os._exit(3)


def has_no_room(code: str, name: str) -> None:
    raise OSError(28, "No space left on device")


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    from arael.distributed import connect

    with connect(workers=1) as found:
        yield found


@pytest.fixture
def content() -> compiled.Content:
    return compiled.content_of(arael.load("linear").compiled)  # type: ignore[attr-defined]


def workers_of(client: Any, *first: str) -> dict[str, compiled.About]:
    addresses = [*first, *client.scheduler_info()["workers"]]
    return {one: compiled.About("", "other", compiler=True) for one in addresses}


def test_a_worker_that_has_left_is_not_waited_for(client: Any, content: compiled.Content) -> None:
    module, why = compiled._compiled_by(client, content, workers_of(client, ABSENT))
    assert module is not None and module[1].startswith(b"\x7fELF")
    assert why == ""
    module, why = compiled._compiled_by(client, content, {ABSENT: compiled.About("", "", True)})
    assert module is None
    assert why == f"the worker that was to compile it has left: {ABSENT}"


@pytest.mark.parametrize(
    ("function", "reason"),
    [(has_no_room, "No space left on device"), (dies, "linear|KilledWorker|dies")],
)
def test_a_worker_that_cannot_compile_is_a_reason(
    client: Any,
    content: compiled.Content,
    monkeypatch: pytest.MonkeyPatch,
    function: Any,
    reason: str,
) -> None:
    monkeypatch.setattr(compiled, "compile_kernels", function)
    module, why = compiled._compiled_by(client, content, workers_of(client))
    assert module is None
    assert "could not compile it" in why
    assert any(word in why for word in reason.split("|"))
