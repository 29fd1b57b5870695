"""Loads a user's program: a Python file with a function ``program(arm)``."""

import sys
import traceback
from collections.abc import Callable
from inspect import iscoroutinefunction
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from rfms_can.errors import ProgramError, RfmsError

if TYPE_CHECKING:
    from rfms_can.rig.session import Program

ENTRY = "program"
MODULE = "rfms_program"
"""Module name of a program: its file name might be that of a library."""
_RIG = str(Path(__file__).parent)


def load_program(path: Path) -> "Program":
    """The program of a file.

    Raises:
        ProgramError: it cannot be read, has a syntax error, fails when loaded, or has no
            ``program(arm)``.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ProgramError(f"program {path} cannot be read: {error}") from error
    module = ModuleType(MODULE)
    module.__file__ = str(path)
    sys.modules[MODULE] = module  # dataclasses look their module up
    sys.path.insert(0, str(path.resolve().parent))  # modules beside it, as ``python FILE`` has it
    try:
        exec(compile(text, str(path), "exec"), vars(module))  # the user's own, on their machine
    except SyntaxError as error:
        where = "" if error.lineno is None else f", line {error.lineno}"
        raise ProgramError(f"program {error.filename or path}{where}: {error.msg}") from error
    except (Exception, SystemExit) as error:
        raise ProgramError(f"program {path}, {_line(error, path)}: {_what(error)}") from error
    program = _entry(module, path)

    def run(arm: Any) -> None:
        try:
            program(arm)
        except ProgramError as error:
            raise type(error)(f"program {path}, {_line(error, path)}: {error}") from error
        except RfmsError:
            raise
        except (Exception, SystemExit) as error:
            if _is_ours(error):
                raise
            raise ProgramError(f"program {path}, {_line(error, path)}: {_what(error)}") from error

    return run


def _entry(module: ModuleType, path: Path) -> Callable[[Any], object]:
    """The program's function; raises ``ProgramError`` as ``load_program`` does."""
    program: Callable[[Any], object] | None = getattr(module, ENTRY, None)
    if not callable(program):
        raise ProgramError(f"program {path} has no function {ENTRY}(arm); define one")
    if iscoroutinefunction(program):
        raise ProgramError(
            f"program {path}: {ENTRY} is a coroutine, which is never awaited here; write def "
            f"{ENTRY}(arm), or drive an AsyncArm with connect_async"
        )
    return program


def _what(error: BaseException) -> str:
    if isinstance(error, SystemExit):
        return f"sys.exit({error.code!r}) would end more than it; return from {ENTRY} instead"
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def _line(error: BaseException, path: Path) -> str:
    """The innermost line of the program in an error's traceback."""
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
    return f"line {lines[-1]}" if lines else "before its first line"


def _is_ours(error: BaseException) -> bool:
    """Whether an error comes from code below the program: a bug, to be shown with its traceback."""
    frames = traceback.extract_tb(error.__traceback__)
    below = [frame for frame in frames if frame.filename.startswith(_RIG)]
    return len(below) > 1  # the first is the call of the program
