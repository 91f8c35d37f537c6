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

tagger_option = click.option(
    "--tagger", default="default", show_default=True, help="default, torch (the reference), or a trained folder."
)


@click.group()
def keywords() -> None:
    """The keyword tagger: tag, train, evaluate."""


@contextmanager
def _told(source: str) -> Iterator[None]:
    """The keywords room's own errors as diagnostics."""
    from llmbt_compiler.keywords.evaluate import ExampleError
    from llmbt_compiler.keywords.grammar import GrammarError
    from llmbt_compiler.keywords.tagger import UnknownTaggerError
    from llmbt_compiler.keywords.weights import BaseWeightsError, WeightsError
    from llmbt_compiler.parsing.evaluate import CaseError

    try:
        yield
    except UnknownTaggerError as fault:
        raise LlmbtError(Diagnostic("E201", str(fault)), exit_code=ExitCode.USAGE) from None
    except (ExampleError, CaseError) as fault:
        raise LlmbtError(Diagnostic("E202", str(fault), Span(source))) from None
    except BaseWeightsError as fault:
        raise LlmbtError(Diagnostic("E203", str(fault))) from None
    except (WeightsError, GrammarError) as fault:
        raise LlmbtError(Diagnostic("E204", str(fault), Span(source))) from None
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
@click.option("--conditions", is_flag=True, help="FILE has steps with their maps and the conditions they mean.")
@click.option("--errors", is_flag=True, help="Show what came out wrong; not for a blind file.")
@click.option("--threshold", type=click.FloatRange(0, 1), default=None, help="With --conditions: as in compile.")
@tagger_option
@json_flag
def evaluate(file: Path, conditions: bool, errors: bool, threshold: float | None, tagger: str, as_json: bool) -> int:
    """Score the tagger on FILE (JSON lines with text and spans): strict spans, each label, whole steps, confusions.

    With --conditions the tagger and the parser together (fixtures/parsing/README.md has the format).
    """
    from llmbt.render import print_json

    if conditions:
        return _evaluate_conditions(file, _load(tagger), threshold, errors=errors, as_json=as_json)
    from llmbt_compiler.keywords.evaluate import evaluate_file, read_examples

    found = _load(tagger)
    with _told(str(file)):
        scores = evaluate_file(file, found)
    if as_json:
        print_json(scores.as_dict(), 0)
        return 0
    s = scores.scores
    click.echo(f"{scores.n} steps: precision {s.precision:.3f}, recall {s.recall:.3f}, F1 {s.f1:.3f} (strict spans)")
    click.echo(f"whole steps right: {scores.whole_step_accuracy:.3f}")
    for kind, k in scores.by_label.items():
        click.echo(f"  {kind.value:<12} P {k.precision:.3f}  R {k.recall:.3f}  F1 {k.f1:.3f}  of {k.n}")
    for (is_, was), n in list(scores.confusions.items())[:8]:
        click.echo(f"  {n:3d} x {is_} taken for {was}")
    if errors:
        examples = read_examples(file)
        for i in scores.wrong:
            click.echo(examples[i].text)
            click.echo("  is        " + "; ".join(f"{s.label.value} {s.text}" for s in examples[i].spans))
            (tagged,) = found.tag([examples[i].text])
            click.echo("  taken for " + "; ".join(f"{s.label.value} {s.text}" for s in tagged.spans))
    return 0


def _evaluate_conditions(file: Path, tagger: Tagger, threshold: float | None, *, errors: bool, as_json: bool) -> int:
    from llmbt.render import print_json
    from llmbt_compiler.parsing.evaluate import Intent, Verdict, evaluate_conditions, wilson
    from llmbt_compiler.parsing.walk import THRESHOLD

    with _told(str(file)):
        scores = evaluate_conditions(file, tagger, threshold=THRESHOLD if threshold is None else threshold)
    if as_json:
        print_json(scores.as_dict(), 0)
        return 0
    click.echo(f"{'':<16}{'cases':>6}{'right':>20}{'refused':>20}{'wrong':>20}")
    for intent in Intent:
        counted = scores.counts[intent]
        n = counted.total()
        cells = []
        for v in Verdict:
            low, high = wilson(counted[v], n)
            cells.append(f"{scores.rate(v, intent):.3f} ({low:.2f}-{high:.2f})" if n else "-")
        click.echo(f"{intent.value:<16}{n:>6}" + "".join(f"{c:>20}" for c in cells))
    low, high = wilson(scores.wrong, scores.n)
    click.echo(f"wrong of all: {scores.wrong} of {scores.n} ({low:.3f}-{high:.3f})")
    for name, counted in sorted(scores.by_phenomenon.items()):
        told = ", ".join(f"{counted[v]} {v}" for v in Verdict if counted[v])
        click.echo(f"  {name or '-':<16}{told}")
    if scores.codes:
        click.echo("refused by code: " + ", ".join(f"{c} {n}" for c, n in sorted(scores.codes.items())))
    if errors:
        for o in scores.outcomes:
            if o.verdict is not Verdict.RIGHT:
                click.echo(f"{o.verdict}: [{o.case.map}] " + " | ".join(o.case.steps))
                click.echo("  meant " + (", ".join(map(str, sorted(o.case.goals[0]))) or o.case.intent.value))
                click.echo("  found " + (", ".join(map(str, o.result.conditions)) or "no goal"))
                for d in o.result.errors():
                    click.echo(f"  {d.code} {d.title}" + (f": {d.label}" if d.label else ""))
    return 0


@keywords.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-n", "count", type=click.IntRange(1), default=50, show_default=True)
@click.option("--seed", type=int, default=0, show_default=True)
def texts(file: Path, count: int, seed: int) -> int:
    """Print the bare texts of some of FILE's steps, drawn by the seed, one a line: for a second annotation."""
    from llmbt_compiler.keywords.agreement import draw_texts

    with _told(str(file)):
        for text in draw_texts(file, count, seed):
            click.echo(text)
    return 0


@keywords.command()
@click.argument("first", type=click.Path(path_type=Path))
@click.argument("second", type=click.Path(path_type=Path))
@json_flag
def agreement(first: Path, second: Path, as_json: bool) -> int:
    """How far two annotations agree on the steps of SECOND (JSON lines, or .txt with `[A Put] the [T cup]`)."""
    from llmbt.render import print_json
    from llmbt_compiler.keywords.agreement import agreement as compare
    from llmbt_compiler.keywords.agreement import read_annotation

    with _told(str(second)):
        found = compare(read_annotation(first), read_annotation(second))
    if as_json:
        print_json(found.as_dict(), 0)
        return 0
    click.echo(f"{found.n} steps: span F1 {found.span_f1:.3f}, whole steps alike {found.whole_step:.3f}")
    click.echo(f"Cohen's kappa over the labels of {found.words} words: {found.kappa:.3f}")
    return 0


@keywords.command()
@click.option("-o", "--out", required=True, type=click.Path(path_type=Path), metavar="DIR", help="For the weights.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--samples", type=click.IntRange(1), default=None, help="Generated sentences in each epoch.")
@click.option("--epochs", type=click.IntRange(1), default=None, help="Of each stage.")
@click.option("--library", default=None, help="Its verbs and types go into the sentences: a shipped one, or a file.")
@click.option("--extra", type=click.Path(path_type=Path), default=None, help="Your own examples, JSON lines.")
@click.option("--dev", type=click.Path(path_type=Path), default=None, help="Score on these after each epoch.")
@click.option(
    "--start-from",
    default=None,
    metavar="shipped|base|DIR",
    help="Train one stage from these weights. [default: shipped with --library or --extra, otherwise both stages]",
)
@quiet
@json_flag
def train(
    out: Path,
    seed: int,
    samples: int | None,
    epochs: int | None,
    library: str | None,
    extra: Path | None,
    dev: Path | None,
    start_from: str | None,
    quiet: bool,
    as_json: bool,
) -> int:
    """Fine-tune the tagger. An interrupted run goes on where it was.

    Without options it makes the shipped weights anew, in two stages: from the base weights (make train-setup) on
    generated steps (about 12 minutes of CPU time), then on with the labelled steps of keywords/data/natural.jsonl
    (about 7). A domain of your own, from the shipped weights, takes about a minute.

    Then: llmbt compile ... --tagger DIR.
    """
    from dataclasses import replace

    from llmbt.progress import training_bar
    from llmbt.render import print_json
    from llmbt_atl.library import load_library
    from llmbt_compiler.keywords.domain import domain_words
    from llmbt_compiler.keywords.evaluate import read_examples
    from llmbt_compiler.keywords.stages import GRAMMAR, NATURAL, train_in_stages
    from llmbt_compiler.keywords.tagger import MODEL
    from llmbt_compiler.keywords.train import DOMAIN, TrainSettings
    from llmbt_compiler.keywords.train import train as run

    def asked(settings: TrainSettings) -> TrainSettings:
        return replace(settings, seed=seed, samples=samples or settings.samples, epochs=epochs or settings.epochs)

    both = start_from is None and not (library or extra)
    with _told(str(extra or dev or out)), training_bar(quiet=quiet or as_json) as progress:
        outside = read_examples(dev) if dev else ()
        if both:
            trained = train_in_stages(out, asked(GRAMMAR), asked(NATURAL), dev=outside, progress=progress)
        else:
            folder = {"shipped": MODEL, "base": None}.get(start_from or "shipped", Path(start_from or ""))
            trained = run(
                out,
                asked(GRAMMAR if folder is None else DOMAIN),
                dev=outside,
                extra=read_examples(extra) if extra else (),
                words=domain_words(load_library(library)) if library else {},
                start_from=folder,
                progress=progress,
            )
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


@keywords.command()
@click.option("-o", "--out", required=True, type=click.Path(path_type=Path), metavar="DIR", help="For the weights.")
@click.option("--dev", type=click.Path(path_type=Path), required=True, help="Labelled steps, JSON lines.")
@click.option("--cases", type=click.Path(path_type=Path), required=True, help="Steps with their conditions.")
@click.option("--samples", type=click.IntRange(1), default=2400, show_default=True)
@click.option("--epochs", type=click.IntRange(1), default=2, show_default=True)
@click.option("--seed", type=int, default=0, show_default=True)
@json_flag
def ablate(out: Path, dev: Path, cases: Path, samples: int, epochs: int, seed: int, as_json: bool) -> int:
    """What each part of the training data, and snapping, is worth: a table, a small training for each row."""
    from dataclasses import replace

    from llmbt.render import print_json
    from llmbt_compiler.keywords.ablate import Outcome
    from llmbt_compiler.keywords.ablate import ablate as run
    from llmbt_compiler.keywords.evaluate import read_examples
    from llmbt_compiler.keywords.stages import GRAMMAR
    from llmbt_compiler.parsing.evaluate import Verdict

    settings = replace(GRAMMAR, seed=seed, samples=samples, epochs=epochs)

    def line(o: Outcome) -> None:
        right, wrong = (o.conditions.rate(v) for v in (Verdict.RIGHT, Verdict.WRONG))
        cells = (o.in_template.scores.f1, o.dev.scores.f1, o.dev.whole_step_accuracy, right, wrong)
        click.echo(f"| {o.row.name} | " + " | ".join(f"{c:.3f}" for c in cells) + " |")

    if not as_json:
        click.echo(f"{samples} samples, {epochs} epochs, seed {seed}\n")
        click.echo("| training data | F1, in-template | F1, outside | whole steps | conditions right | wrong |")
        click.echo("|---|---|---|---|---|---|")
    with _told(str(dev)):
        found = run(out, settings, read_examples(dev), cases, observe=line if not as_json else lambda _: None)
    if as_json:
        rows = [
            {
                "name": o.row.name,
                "in_template": o.in_template.as_dict(),
                "dev": o.dev.as_dict(),
                "conditions": o.conditions.as_dict(),
            }
            for o in found
        ]
        print_json({"samples": samples, "epochs": epochs, "seed": seed, "rows": rows}, 0)
    return 0
