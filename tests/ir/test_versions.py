"""The store of tree versions: append-only, whole after a kill at any moment, honest about what was edited."""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.tree_xml import parse_tree, write_tree
from llmbt_ir.versions import VersionStore, sha256, version_name, write_atomic
from tests.strategies import SIGNATURES, deep_tree

XML = write_tree(deep_tree(4), SIGNATURES)

WRITER = """
import sys
from pathlib import Path
from llmbt_ir.versions import VersionStore
store, body = VersionStore(Path(sys.argv[1])), b"<!-- " + b"x" * 200_000 + b" -->"
print("ready", flush=True)
number = max((v.number for v in store.versions()), default=-1) + 1
while True:
    store.append(b"<root/>" + body, {"parent": number - 1, "padding": "y" * 50_000}, number)
    number += 1
"""


def test_versions_are_numbered_and_read_back_in_order(tmp_path: Path) -> None:
    store = VersionStore(tmp_path)
    assert store.versions() == ()
    for number in (0, 1, 2, 10, 1_000):
        store.append(XML, {"cause": f"no {number}"}, number)
    found = store.versions()
    assert [v.number for v in found] == [0, 1, 2, 10, 1_000]
    assert [v.name for v in found] == ["v000", "v001", "v002", "v010", "v1000"]
    assert [v.record["cause"] for v in found] == [f"no {n}" for n in (0, 1, 2, 10, 1_000)]
    assert all(v.record["sha256"] == sha256(v.path.read_bytes()) for v in found)
    assert version_name(7) == "v007"


def test_a_version_is_never_written_over(tmp_path: Path) -> None:
    store = VersionStore(tmp_path)
    store.append(XML, {}, 1)
    with pytest.raises(FileExistsError):
        store.append(XML + b"\n", {}, 1)
    assert store.versions()[0].path.read_bytes() == XML


def test_a_tree_without_a_record_is_no_version_and_may_be_written_again(tmp_path: Path) -> None:
    (tmp_path / "tree.v003.xml").write_bytes(b"<half")
    store = VersionStore(tmp_path)
    assert store.versions() == ()
    store.append(XML, {}, 3)
    assert store.versions()[0].path.read_bytes() == XML


@pytest.mark.parametrize(
    "name", ["tree.v01.json", "tree.v0001.json", "tree.vabc.json", "tree.v001.json.bak", ".tree.v001.json.x"]
)
def test_other_files_are_no_versions(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("{}")
    (tmp_path / name).with_suffix(".xml").write_bytes(XML)
    assert VersionStore(tmp_path).versions() == ()


def test_an_edited_tree_is_found_out(tmp_path: Path) -> None:
    store = VersionStore(tmp_path)
    path = store.append(XML, {}, 0).path
    path.write_bytes(XML.replace(b"P0", b"P1"))
    with pytest.raises(LlmbtError) as caught:
        store.versions()
    (found,) = caught.value.diagnostics
    assert (found.code, found.span and found.span.source) == ("E060", str(path))
    assert "folder of its own" in found.help


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '"x"', "{}", "\ud800"])
def test_a_record_that_is_none_is_a_diagnostic(tmp_path: Path, text: str) -> None:
    VersionStore(tmp_path).append(XML, {}, 0)
    (tmp_path / "tree.v000.json").write_bytes(text.encode("utf-8", "surrogatepass"))
    with pytest.raises(LlmbtError) as caught:
        VersionStore(tmp_path).versions()
    assert caught.value.diagnostics[0].code == "E060"


def test_a_failed_write_leaves_the_old_file_and_no_rubbish(tmp_path: Path) -> None:
    write_atomic(tmp_path / "result.json", b"old")
    with pytest.raises(TypeError):
        write_atomic(tmp_path / "result.json", "not bytes")  # type: ignore[arg-type]
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == {"result.json": b"old"}


def test_whole_files_only_after_thirty_kills(tmp_path: Path) -> None:
    """A writer is killed 30 times at random moments; each time every version that is there is whole, none is lost."""
    rng = random.Random(0)
    store, kept = VersionStore(tmp_path), 0
    for _ in range(30):
        with subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path)], stdout=subprocess.PIPE) as writer:
            assert writer.stdout is not None
            writer.stdout.readline()
            time.sleep(rng.uniform(0, 0.03))
            writer.send_signal(signal.SIGKILL)
        found = store.versions()
        assert [v.number for v in found] == list(range(len(found)))
        assert len(found) >= kept
        assert all(len(v.path.read_bytes()) > 200_000 and v.record["padding"] == "y" * 50_000 for v in found)
        kept = len(found)
    assert kept > 10
    for path in tmp_path.glob("tree.v*.json"):
        json.loads(path.read_bytes())


def test_a_stored_tree_parses(tmp_path: Path) -> None:
    version = VersionStore(tmp_path).append(XML, {}, 0)
    assert parse_tree(version.path.read_bytes(), "v").tree == deep_tree(4)
