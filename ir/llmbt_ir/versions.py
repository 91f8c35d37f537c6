"""The store of tree versions in a run's folder: append-only, and whole after a kill at any moment.

`tree.v007.xml` is the tree, `tree.v007.json` the authoritative record of how it came about, with the hash of the XML
and of its parent's. The record is written last: a tree without a record is not a version.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span

__all__ = ["Version", "VersionStore", "sha256", "version_name", "write_atomic"]


def sha256(data: bytes) -> str:
    """The hash of a file's bytes, in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def version_name(number: int) -> str:
    """`v000`, `v001`, ...: at least three digits."""
    return f"v{number:03d}"


def write_atomic(path: Path, data: bytes) -> None:
    """Write a file so that a reader, or a machine that dies, sees the whole of it or nothing of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as out:
            out.write(data)
            out.flush()
            os.fsync(out.fileno())
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


@dataclass(frozen=True, slots=True)
class Version:
    """One version: its number, its tree file, and its record."""

    number: int
    path: Path
    record: Mapping[str, Any]

    @property
    def name(self) -> str:
        """As `v007`."""
        return version_name(self.number)


@dataclass(frozen=True, slots=True)
class VersionStore:
    """The versions in one folder."""

    folder: Path

    def versions(self) -> tuple[Version, ...]:
        """All whole versions, by number. E060: a record that cannot be read, or does not match its tree."""
        found = []
        for path in self.folder.glob("tree.v*.json"):
            match = re.fullmatch(r"tree\.v(\d{3,})\.json", path.name)
            tree = path.with_suffix(".xml")
            if match is None or path.stem != f"tree.{version_name(int(match[1]))}" or not tree.is_file():
                continue
            try:
                record = json.loads(path.read_bytes())
            except (ValueError, OSError) as fault:
                raise LlmbtError(Diagnostic("E060", f"not a version record: {fault}", Span(str(path)))) from None
            if not isinstance(record, dict):
                raise LlmbtError(Diagnostic("E060", "not a version record: no JSON object", Span(str(path))))
            if record.get("sha256") != sha256(tree.read_bytes()):
                raise LlmbtError(
                    Diagnostic(
                        "E060",
                        f"`{tree.name}` is not the tree that `{path.name}` records",
                        Span(str(tree)),
                        help="it was edited after it was written; execute the edited file into a folder of its own",
                    )
                )
            found.append(Version(int(match[1]), tree, record))
        return tuple(sorted(found, key=lambda v: v.number))

    def append(self, tree_xml: bytes, record: Mapping[str, Any], number: int) -> Version:
        """Add a version. `record` gets the version's name, file and hash. The number must not be taken."""
        path = self.folder / f"tree.{version_name(number)}.xml"
        sidecar = path.with_suffix(".json")
        if sidecar.exists():
            raise FileExistsError(sidecar)
        whole = {
            "schema_version": 1,
            "version": version_name(number),
            "file": path.name,
            "sha256": sha256(tree_xml),
        }
        whole.update(record)
        write_atomic(path, tree_xml)
        write_atomic(sidecar, (json.dumps(whole, indent=1, ensure_ascii=False) + "\n").encode())
        return Version(number, path, whole)
