"""The entry point: commands are imported when they are called, faults become diagnostics and exit codes."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Mapping

import click

from llmbt import __version__
from llmbt_ir.diagnostics import ExitCode, LlmbtError

__all__ = ["cli", "main"]

COMMANDS: Mapping[str, tuple[str, str]] = {
    "compile": ("llmbt.commands.compile:compile_", "A request and a scene to an initial behaviour tree."),
    "execute": ("llmbt.commands.execute:execute", "Run a tree against a world and let it grow."),
    "run": ("llmbt.commands.run:run", "Compile a request and execute its tree."),
    "experiment": ("llmbt.commands.experiment:experiment", "Many trials: the paper's tables, and other methods."),
    "report": ("llmbt.commands.report:report", "A run, or an experiment, as a page to read."),
    "solve": ("llmbt.commands.solve:solve", "Run the update loop on a PDDL problem."),
    "tree": ("llmbt.commands.tree:tree", "Look at trees."),
    "scene": ("llmbt.commands.scene:scene", "Scenes: what stands where, pictures, faults, clouds."),
    "atl": ("llmbt.commands.atl:atl", "Action template libraries."),
    "keywords": ("llmbt.commands.keywords:keywords", "The keyword tagger: tag, train, evaluate."),
    "cassette": ("llmbt.commands.cassette:cassette", "Recordings of the language model."),
    "doctor": ("llmbt.commands.doctor:doctor", "What is missing on this machine, and how to mend it."),
}


class LazyGroup(click.Group):
    """A group that imports a command only when it is called, so that `--help` answers at once."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """In the order of the work, not of the alphabet."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return a command; None where there is no such one."""
        if cmd_name not in COMMANDS:
            return None
        module, _, attribute = COMMANDS[cmd_name][0].partition(":")
        found = getattr(importlib.import_module(module), attribute)
        assert isinstance(found, click.Command)
        return found

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The table of commands, from their one-line texts alone."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="llmbt")
def cli() -> None:
    """From a sentence to a behaviour tree that grows while it runs."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; the exit code. Never raises but for SystemExit by click's own options."""
    arguments = sys.argv[1:] if arguments is None else arguments
    json_wanted = "--json" in arguments
    try:
        code = cli.main(arguments, prog_name="llmbt", standalone_mode=False)
        return int(code or 0)
    except LlmbtError as fault:
        from llmbt.render import report

        report(fault.diagnostics, fault.exit_code, as_json=json_wanted)
        return int(fault.exit_code)
    except click.exceptions.Abort:
        return int(ExitCode.INTERRUPTED)
    except click.ClickException as fault:
        if json_wanted:
            from llmbt.render import usage_json

            usage_json(fault.format_message())
        else:
            fault.show()
        return int(ExitCode.USAGE)
    except KeyboardInterrupt:
        return int(ExitCode.INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        return int(ExitCode.OK)
    except Exception:
        from llmbt.render import internal_error

        internal_error(as_json=json_wanted)
        return int(ExitCode.INTERNAL)


def entry() -> None:
    """The console script. One thread for numpy's matrix products: on shared cores two only get in each other's way."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.exit(main())
