"""The recordings of an experiment's requests, one file a dialogue, made from the replies that its cases hold."""

from __future__ import annotations

from collections.abc import Iterator

from llmbt.experiment.cases import Case, Experiment, cassette_of
from llmbt_compiler.reasoning.author import Authored, author
from llmbt_compiler.reasoning.cassette import read_cassette
from llmbt_ir.scene import to_semantic_map

__all__ = ["author_experiment"]


def author_experiment(experiment: Experiment) -> Iterator[Authored]:
    """Make the recording of every request that has a reply. One recorded from a model stays as it is."""
    for case in experiment.cases:
        yield from _author_case(case)


def _author_case(case: Case) -> Iterator[Authored]:
    semantic_map = to_semantic_map(case.scene)
    for request in case.requests:
        path = cassette_of(case, request)
        if request.reply is None or (path.exists() and not read_cassette(path).provenance.authored):
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        yield author(
            request.text, semantic_map, case.library, [request.reply], path, scene=case.scene.name, date=case.date
        )
