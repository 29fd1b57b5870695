"""One mutant: a file of the joint's code in which one stretch of text is another."""

from pathlib import Path
from typing import Final, NamedTuple

import rfms_can
from rfms_can.errors import RfmsError

PACKAGE: Final = Path(rfms_can.__file__).parent


class Mutant(NamedTuple):
    """What is wrong, and where.

    Attributes:
        name: unique among all; of those by hand in words.
        file: under ``rfms_can/``.
        line: of the file, where it begins.
        kind: operator, or ``by hand``.
        before, after: the text, and what stands there instead.
        begin: where ``before`` begins in the file, characters.
    """

    name: str
    file: str
    line: int
    kind: str
    before: str
    after: str
    begin: int

    @property
    def source(self) -> str:
        """The whole file of the mutant.

        Raises:
            RfmsError: the file is another one by now.
        """
        text = source_of(self.file)
        end = self.begin + len(self.before)
        if text[self.begin : end] != self.before:
            raise RfmsError(f"{self.file}:{self.line} does not read {self.before!r} any more")
        return text[: self.begin] + self.after + text[end:]

    @property
    def module(self) -> str:
        """Name of the module that the file is."""
        return "rfms_can." + self.file.removesuffix(".py").replace("/", ".")


def source_of(file: str) -> str:
    """Text of a file under ``rfms_can/``."""
    return (PACKAGE / file).read_text(encoding="utf-8")
