"""`llmbt keywords`: the tagger."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from llmbt.options import json_flag, quiet
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span

if TYPE_CHECKING:
    from llmbt_compiler.keywords.labels import TaggedStep
    from llmbt_compiler.keywords.tagger import Tagger

__all__ = ["keywords"]

tagger_option = click.option("--tagger", default="default", show_default=True, help="default or torch (the reference).")


@click.group()
def keywords() -> None:
    """The keyword tagger: tag, train, evaluate."""


@contextmanager
def _told(source: str) -> Iterator[None]:
    """The keywords room's own errors as diagnostics."""
    from llmbt_compiler.keywords.evaluate import ExampleError
    from llmbt_compiler.keywords.tagger import UnknownTaggerError

    try:
        yield
    except UnknownTaggerError as fault:
        raise LlmbtError(Diagnostic("E201", str(fault)), exit_code=ExitCode.USAGE) from None
    except ExampleError as fault:
        raise LlmbtError(Diagnostic("E202", str(fault), Span(source))) from None
    except OSError as fault:
        title = f"cannot read `{source}`: {fault.strerror or fault}"
        raise LlmbtError(Diagnostic("E001", title, Span(source))) from None


def _load(name: str) -> Tagger:
    from llmbt_compiler.keywords.tagger import load_tagger

    with _told(name):
        return load_tagger(name)


def _spans(step: TaggedStep) -> list[dict[str, Any]]:
    return [
        {
            "start": s.start,
            "end": s.end,
            "label": s.label.value,
            "text": s.text,
            "confidence": round(s.confidence, 4),
        }
        for s in step.spans
    ]


@keywords.command()
@click.argument("step", metavar="STEP|FILE.jsonl|-")
@tagger_option
@json_flag
def tag(step: str, tagger: str, as_json: bool) -> int:
    """Label the keywords of a sentence, of each line of standard input (-), or of a .jsonl file's texts."""
    from llmbt.render import print_json
    from llmbt_ir.xml import read_bytes

    is_file = step.endswith(".jsonl")
    if is_file:
        lines = read_bytes(Path(step), "file").decode("utf-8", "replace").splitlines()
        texts = [_text_of(line, step, i) for i, line in enumerate(lines, 1) if line.strip()]
    elif step == "-":
        texts = [line.strip() for line in sys.stdin if line.strip()]
    else:
        texts = [step]
    tagged = _load(tagger).tag(texts)
    if as_json and is_file:
        for found in tagged:
            print(json.dumps({"spans": _spans(found)}, ensure_ascii=False))
    elif as_json:
        print_json({"steps": [{"text": t.text, "spans": _spans(t)} for t in tagged]}, 0)
    else:
        for found in tagged:
            click.echo(found.text)
            for s in found.spans:
                click.echo(f"  {s.label.value:<12} {s.text}")
    return 0


def _text_of(line: str, source: str, number: int) -> str:
    try:
        text = json.loads(line)["text"]
    except (ValueError, KeyError, TypeError):
        text = None
    if not isinstance(text, str):
        raise LlmbtError(Diagnostic("E202", 'a line is {"text": ...}', Span(source, number, text=line[:200])))
    return text


@keywords.command(name="eval")
@click.argument("file", type=click.Path(path_type=Path))
@tagger_option
@json_flag
def evaluate(file: Path, tagger: str, as_json: bool) -> int:
    """Score the tagger on FILE (JSON lines with text and spans): strict spans, each label, whole steps, confusions."""
    from llmbt.render import print_json
    from llmbt_compiler.keywords.evaluate import evaluate_file

    found = _load(tagger)
    with _told(str(file)):
        scores = evaluate_file(file, found)
    document = scores.as_dict()
    if as_json:
        print_json(document, 0)
        return 0
    s = scores.scores
    click.echo(f"{scores.n} steps: precision {s.precision:.3f}, recall {s.recall:.3f}, F1 {s.f1:.3f} (strict spans)")
    click.echo(f"whole steps right: {scores.whole_step_accuracy:.3f}")
    for kind, k in scores.by_label.items():
        click.echo(f"  {kind.value:<12} P {k.precision:.3f}  R {k.recall:.3f}  F1 {k.f1:.3f}  of {k.n}")
    for (is_, was), n in list(scores.confusions.items())[:8]:
        click.echo(f"  {n:3d} x {is_} taken for {was}")
    return 0


@keywords.command()
@click.option("-o", "--out", required=True, type=click.Path(path_type=Path), metavar="DIR", help="For the weights.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--samples", type=click.IntRange(1), default=None, help="Generated sentences.")
@click.option("--epochs", type=click.IntRange(1), default=None)
@click.option("--extra", type=click.Path(path_type=Path), default=None, help="Your own examples, JSON lines.")
@click.option("--dev", type=click.Path(path_type=Path), default=None, help="Score on these after each epoch.")
@quiet
@json_flag
def train(
    out: Path,
    seed: int,
    samples: int | None,
    epochs: int | None,
    extra: Path | None,
    dev: Path | None,
    quiet: bool,
    as_json: bool,
) -> int:
    """Fine-tune the tagger (needs the base weights: make train-setup). An interrupted run goes on where it was."""
    from dataclasses import replace

    from llmbt.progress import training_bar
    from llmbt.render import print_json
    from llmbt_compiler.keywords.evaluate import read_examples
    from llmbt_compiler.keywords.train import BaseWeightsError, TrainSettings
    from llmbt_compiler.keywords.train import train as run

    settings = TrainSettings(seed=seed)
    settings = replace(settings, samples=samples or settings.samples, epochs=epochs or settings.epochs)
    with _told(str(extra or dev or out)), training_bar(quiet=quiet or as_json) as progress:
        try:
            trained = run(
                out,
                settings,
                dev=read_examples(dev) if dev else (),
                extra=read_examples(extra) if extra else (),
                progress=progress,
            )
        except BaseWeightsError as fault:
            raise LlmbtError(Diagnostic("E203", str(fault))) from None
    document: dict[str, Any] = {"folder": str(out), "in_template": trained.in_template.as_dict()}
    if trained.dev is not None:
        document["dev"] = trained.dev.as_dict()
    if as_json:
        print_json(document, 0)
        return 0
    click.echo(f"{out}: in-template F1 {trained.in_template.scores.f1:.3f}")
    if trained.dev is not None:
        click.echo(f"outside: F1 {trained.dev.scores.f1:.3f}, whole steps {trained.dev.whole_step_accuracy:.3f}")
    return 0
