"""What an experiment's folder holds once trials are in it: the tables, as numbers and in the forms people want."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from llmbt.experiment.tables import Table
from llmbt_ir.versions import write_atomic

__all__ = ["TABLE", "write_results"]

TABLE = "table.json"


def write_results(folder: Path, header: Mapping[str, Any], tables: Sequence[Table], counts: Mapping[str, Any]) -> None:
    """Write `table.json` and, for each table, .md, .csv and .tex in `tables/`. The same trials give the same bytes: no
    time of day, no wall time, no host."""
    document = {**header, "tables": [t.as_json() for t in tables], "counts": counts}
    write_atomic(folder / TABLE, (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode())
    for table in tables:
        for suffix, text in (("md", table.markdown()), ("csv", table.csv()), ("tex", table.latex())):
            write_atomic(folder / "tables" / f"{table.name}.{suffix}", text.encode())
