"""`llmbt doctor`: what is missing, and the command that mends it."""

from __future__ import annotations

import importlib
import importlib.metadata
import sys
from collections.abc import Callable
from dataclasses import dataclass

import click

from llmbt.options import json_flag
from llmbt_ir.diagnostics import ExitCode, LlmbtError

__all__ = ["doctor"]


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing looked at: whether it is right, what was found, how to mend it."""

    name: str
    ok: bool
    found: str
    mend: str = ""


def _python() -> Finding:
    version = ".".join(map(str, sys.version_info[:3]))
    right = sys.version_info[:2] == (3, 11)
    return Finding("python", right, version, "" if right else "use Python 3.11: pybullet has no wheels beyond it")


def _package(name: str, module: str) -> Callable[[], Finding]:
    def look() -> Finding:
        try:
            version = importlib.metadata.version(name)
            importlib.import_module(module)
        except Exception as fault:
            return Finding(name, False, f"{type(fault).__name__}: {fault}", f"pip install -c constraints.txt {name}")
        return Finding(name, True, version)

    return look


def _torch() -> Finding:
    try:
        import torch
    except Exception as fault:
        return Finding("torch", False, str(fault), "pip install -c constraints.txt torch")
    build = f"CUDA {torch.version.cuda}" if torch.version.cuda else "CPU"
    note = "" if not torch.version.cuda else "; the CPU build is enough and some 3 GB smaller"
    return Finding("torch", True, f"{torch.__version__}, {build} build{note}")


def _pybullet() -> Finding:
    try:
        from llmbt_runtime.bullet.client import BulletClient

        BulletClient().close()
        return Finding("pybullet", True, f"{importlib.metadata.version('pybullet')}, a world can be made")
    except Exception as fault:
        return Finding("pybullet", False, f"{type(fault).__name__}: {fault}", "pip install -c constraints.txt pybullet")


def _open3d() -> Finding:
    from llmbt_compiler.recognition.open3d import open3d

    try:
        module = open3d()
    except LlmbtError as fault:
        return Finding("open3d", False, str(fault), "pip install -c constraints.txt open3d-cpu libusb-package")
    return Finding("open3d", True, f"{module.__version__}, with libusb from the package libusb-package")


def _weights() -> Finding:
    from llmbt_compiler.keywords.tagger import load_tagger

    try:
        tagged = load_tagger().tag(["Pick up object 1."])
        return Finding("tagger", bool(tagged[0].spans), "the shipped weights load and tag")
    except Exception as fault:
        return Finding("tagger", False, str(fault), "install the package again: its weights are missing or damaged")


def _shipped() -> Finding:
    from llmbt_atl.library import library_names
    from llmbt_ir.scene import scene_names
    from llmbt_ir.shipped import shipped

    tapes = len(list(shipped("llm_cassettes").glob("**/*.yaml")))
    text = f"{len(scene_names())} scenes, {len(library_names())} libraries, {tapes} recordings"
    return Finding(
        "shipped files", bool(scene_names() and library_names() and tapes), text, "install the package again"
    )


CHECKS: tuple[Callable[[], Finding], ...] = (
    _python,
    _package("lxml", "lxml.etree"),
    _package("numpy", "numpy"),
    _package("openai", "openai"),
    _package("vcrpy", "vcr"),
    _package("transformers", "transformers"),
    _torch,
    _pybullet,
    _open3d,
    _weights,
    _shipped,
)


@click.command()
@json_flag
def doctor(as_json: bool) -> int:
    """Say what is missing on this machine and how to mend it (exit code 6 where something is)."""
    from llmbt.render import print_json

    found = [check() for check in CHECKS]
    code = ExitCode.OK if all(f.ok for f in found) else ExitCode.DIFFERENCES
    if as_json:
        rows = [{"name": f.name, "ok": f.ok, "found": f.found, "mend": f.mend} for f in found]
        print_json({"findings": rows}, code)
        return int(code)
    for f in found:
        click.echo(f"{'ok     ' if f.ok else 'MISSING'} {f.name:<14} {f.found}")
        if f.mend and not f.ok:
            click.echo(f"        {'':<14} mend: {f.mend}")
    return int(code)
