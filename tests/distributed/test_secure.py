"""Connections with certificates."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import arael
from arael.diagnostics.records import AraelError
from tests.optional import needs

pytestmark = [needs("Dask"), needs("cryptography")]

MODEL = "root One : f64 { param a: real; target: real\n constraint near { a - target } }"


def certificates(folder: Path) -> dict[str, str]:
    """Files of a certificate that is its own authority, and of its key."""
    from distributed import Security

    made = Security.temporary()
    texts = {
        "tls_ca": made.tls_ca_file,
        "tls_cert": made.tls_client_cert,
        "tls_key": made.tls_client_key,
    }
    for name, text in texts.items():
        (folder / f"{name}.pem").write_text(text)
    return {name: str(folder / f"{name}.pem") for name in texts}


def test_problems_are_solved_over_encrypted_connections_only(tmp_path: Path) -> None:
    from arael.distributed import connect
    from arael.distributed import map as solve_all

    (tmp_path / "one.json").write_text(json.dumps({"a": 0, "target": 3}))
    own = certificates(tmp_path)
    other = tmp_path / "other"
    other.mkdir()
    untrusted = certificates(other)
    kind = arael.loads(MODEL, interpret=True)
    with connect(workers=1, **own) as local:
        address = local.scheduler.address
        assert address.startswith("tls://")
        assert all(worker.startswith("tls://") for worker in local.nthreads())
        with connect(scheduler=address, **own) as client:
            (row,) = (f.result() for f in solve_all(kind, [tmp_path / "one.json"], client))
            assert row.parameters == {"a": pytest.approx(3)}
        for given in ({}, untrusted):
            with (
                pytest.raises(AraelError, match="E0881"),
                connect(scheduler=address, timeout=0.5, **given),
            ):
                pass


def test_a_missing_certificate_is_named(tmp_path: Path) -> None:
    from arael.distributed import connect

    with (
        pytest.raises(AraelError, match=r"the file of --tls-cert cannot be read"),
        connect(workers=1, tls_cert=str(tmp_path / "absent.pem")),
    ):
        pass
