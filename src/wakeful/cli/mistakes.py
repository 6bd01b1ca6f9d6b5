"""What a user got wrong, in one line with a way out; and the group that prints it so."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

import click

from wakeful.contracts.bridge import SourceError
from wakeful.contracts.domain import DomainError
from wakeful.contracts.journal import JournalError
from wakeful.contracts.learner import MissingLearner
from wakeful.journal.export import MissingExtra
from wakeful.journal.wording.words import plain

FAILED, USAGE, INTERRUPTED = 1, 2, 130


class Mistake(click.ClickException):
    """Something that the user can put right. The message says what is wrong and what to do."""

    exit_code = FAILED


class OneLine(click.Group):
    """A command group whose every error is one line on standard error: no usage text, no traceback for a user's mistake."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Run, and end the program with 0, 1 (failed), 2 (usage) or 130 (interrupted)."""
        if sys.stdout is None:
            _end("standard output is closed, there is nowhere to print to; send it to a file, or to /dev/null", FAILED)
        try:
            result = super().main(args, prog_name, complete_var, standalone_mode=False, **extra)
            sys.stdout.flush()
        except click.UsageError as error:
            where = error.ctx.command_path if error.ctx else "wakeful"
            _end(f"{_first_line(error)} Try '{where} --help'.", USAGE)
        except click.Abort:
            _end("interrupted", INTERRUPTED)
        except KeyboardInterrupt:
            _end("interrupted", INTERRUPTED)
        except click.ClickException as error:
            _end(error.format_message(), error.exit_code)
        except (JournalError, SourceError, DomainError, MissingExtra, MissingLearner) as error:
            _end(str(error), FAILED)
        except BrokenPipeError:
            # Whoever read our output has gone; what is left in the buffer must not complain either.
            _let_go_of_output()
            sys.exit(FAILED)
        except OSError as error:
            # What has a name is said by it; what has none is the output, whose place is full or gone.
            _let_go_of_output()
            where = f"{error.filename}: " if error.filename else "standard output cannot be written: "
            _end(f"{where}{error.strerror or error}; free the place, or name another", FAILED)
        if standalone_mode:
            sys.exit(result if isinstance(result, int) else 0)
        return result


def _let_go_of_output() -> None:
    """Whatever is left in the buffer goes nowhere, so that the interpreter does not fail over it at its end."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError):
        return  # it is no file of the system's, as under a test


def _first_line(error: click.UsageError) -> str:
    text = error.format_message().strip()
    return text if text.endswith((".", "?", "!")) else text + "."


def _end(says: str, code: int) -> NoReturn:
    click.echo(click.style("error: ", fg="red", bold=True) + plain(says), err=True)
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        _let_go_of_output()
    sys.exit(code)
