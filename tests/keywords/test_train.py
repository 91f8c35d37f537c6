"""Training: goes on from the shipped weights for a handful of steps, resumes, repeats."""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt_compiler.keywords.evaluate import Example
from llmbt_compiler.keywords.tagger import MODEL, OnnxTagger


@pytest.mark.slow
def test_one_seed_gives_one_tagger_interrupted_or_not(tmp_path: Path, dev: tuple[Example, ...]) -> None:
    from llmbt_compiler.keywords.train import Progress, TrainSettings, train

    settings = TrainSettings(seed=1, samples=24, epochs=2, batch=8, learning_rate=1e-5, held_out=20)
    seen: list[Progress] = []
    whole = train(tmp_path / "whole", settings, start_from=MODEL, dev=dev[:8], extra=dev[:2], progress=seen.append)
    assert len(whole.losses) == 2
    assert seen[-1].done == seen[-1].total
    assert whole.dev is not None
    assert whole.dev.n == 8
    assert not (tmp_path / "whole" / "checkpoint.pt").exists()

    class StopHereError(Exception):
        pass

    def stop(p: Progress) -> None:
        if p.epoch == 1:
            raise StopHereError

    with pytest.raises(StopHereError):
        train(tmp_path / "parts", settings, start_from=MODEL, extra=dev[:2], progress=stop)
    assert (tmp_path / "parts" / "checkpoint.pt").exists()
    resumed: list[Progress] = []
    parts = train(tmp_path / "parts", settings, start_from=MODEL, extra=dev[:2], progress=resumed.append)
    assert min(p.epoch for p in resumed) == 1
    assert parts.losses == pytest.approx(whole.losses, rel=1e-4)

    again = train(tmp_path / "again", settings, start_from=MODEL, extra=dev[:2])
    assert again.losses == whole.losses
    texts = [e.text for e in dev]
    a, b, c = (OnnxTagger(tmp_path / name).tag(texts) for name in ("whole", "parts", "again"))
    labels = [[w.label for w in s.words] for s in a]
    assert labels == [[w.label for w in s.words] for s in b]
    assert labels == [[w.label for w in s.words] for s in c]


def test_missing_base_weights_are_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    from llmbt_compiler.keywords import train

    monkeypatch.setattr(train, "BASE_PACKAGE", "no_such_package")
    with pytest.raises(train.BaseWeightsError, match="make train-setup"):
        train.find_base()
