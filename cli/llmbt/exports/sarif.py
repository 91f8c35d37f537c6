"""Findings in SARIF 2.1.0, which code hosts and editors show beside the lines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any
from urllib.parse import quote

from llmbt_ir.diagnostics import Diagnostic

__all__ = ["sarif"]


def sarif(diagnostics: Iterable[Diagnostic], rules: Mapping[str, str], version: str) -> dict[str, Any]:
    """One run with its rules and results."""
    found = tuple(diagnostics)
    used = sorted({d.code for d in found} | set(rules))
    index = {code: k for k, code in enumerate(used)}
    return {
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "llmbt tree check",
                        "version": version,
                        "rules": [{"id": c, "shortDescription": {"text": rules.get(c, c)}} for c in used],
                    }
                },
                "columnKind": "unicodeCodePoints",
                "results": [_result(d, index[d.code]) for d in found],
            }
        ],
    }


def _result(diagnostic: Diagnostic, rule: int) -> dict[str, Any]:
    text = diagnostic.title + (f". {diagnostic.help}" if diagnostic.help else "")
    result: dict[str, Any] = {
        "ruleId": diagnostic.code,
        "ruleIndex": rule,
        "level": diagnostic.severity.value,
        "message": {"text": text},
    }
    span = diagnostic.span
    if span is not None:
        place: dict[str, Any] = {"artifactLocation": {"uri": quote(span.source)}}
        if span.line:
            place["region"] = {"startLine": span.line}
            if span.column:
                place["region"] |= {"startColumn": span.column, "endColumn": max(span.end_column, span.column + 1)}
        result["locations"] = [{"physicalLocation": place}]
    return result
