"""Loads a user's program: a Python file with a function ``program(arm)``."""

import traceback
from pathlib import Path
from typing import Any

from rfms_can.errors import ProgramError
from rfms_can.rig.session import Program

ENTRY = "program"


def load_program(path: Path) -> Program:
    """The program of a file.

    Raises:
        ProgramError: it is not there, is no Python, fails when loaded, or has no ``program(arm)``.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ProgramError(f"program {path} cannot be read: {error}") from error
    scope: dict[str, Any] = {"__name__": path.stem, "__file__": str(path)}
    try:
        exec(compile(text, str(path), "exec"), scope)  # the user's own program, on their machine
    except SyntaxError as error:
        raise ProgramError(f"program {path}, line {error.lineno}: {error.msg}") from error
    except Exception as error:
        raise ProgramError(f"program {path}{_line(error, path)}: {_what(error)}") from error
    program = scope.get(ENTRY)
    if not callable(program):
        raise ProgramError(f"program {path} has no function {ENTRY}(arm); define one")

    def run(arm: Any) -> None:
        try:
            program(arm)
        except ProgramError:
            raise
        except Exception as error:
            if _line(error, path):
                raise ProgramError(f"program {path}{_line(error, path)}: {_what(error)}") from error
            raise

    return run


def _what(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def _line(error: Exception, path: Path) -> str:
    """Where in the program an error comes from, if that is where it comes from."""
    frames = traceback.extract_tb(error.__traceback__)
    if frames and frames[-1].filename == str(path):
        return f", line {frames[-1].lineno}"
    return ""
