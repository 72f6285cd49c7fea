"""What an agent asks for is broken off by a person in the editor."""

from __future__ import annotations

from pathlib import Path

import pytest

from arael.diagnostics.records import AraelError
from tests.optional import needs, require
from tests.sketch.server.shared import chain, shared_sketch
from tests.sketch.server.test_breaking_off import break_at

pytestmark = needs("mcp")


def test_what_an_agent_asks_is_broken_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    require("mcp")
    from arael.sketch.agents.tools import Agents
    from arael.sketch.server.worker import Worker

    shared = shared_sketch(chain(tmp_path / "chain.json", 400))
    agents = Agents(Worker(shared), "nowhere")
    with monkeypatch.context() as patch:
        break_at(patch, shared, 0)
        with pytest.raises(AraelError, match="E1235"):
            agents._state()
    shared.resume()
    assert agents._state()["degrees_of_freedom"] > 0
