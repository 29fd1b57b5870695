"""What results of a job depend on besides the job: the code, Python, and the libraries."""

import hashlib
import platform
import re
from collections.abc import Iterable, Iterator, Sequence
from importlib import metadata
from pathlib import Path
from typing import Final, NamedTuple

PACKAGE: Final = Path(__file__).resolve().parents[1]
CHECKOUT: Final = PACKAGE.parent
BUNDLED: Final = {
    "dbc/rfms.dbc": "rfms.dbc",
    "examples/peg_in_hole.py": "examples/peg_in_hole.py",
}
"""Files of a checkout that an installed package has inside: ``force-include`` of pyproject.toml."""
_DIGITS: Final = 12


class Stamp(NamedTuple):
    """The versions of one machine.

    Attributes:
        code: digest of the package, whether it is a checkout or installed.
        folders: of the checkout that jobs' code lies in, and their digests; "" if not there.
        python: its version, without the last number.
        libraries: versions of what the package depends on.
    """

    code: str
    folders: tuple[tuple[str, str], ...]
    python: str
    libraries: tuple[tuple[str, str], ...]

    @classmethod
    def here(cls, folders: Sequence[str] = ()) -> "Stamp":
        """That of this process' machine."""
        return cls(
            _digest(_package_files()),
            tuple((name, _folder_digest(name)) for name in folders),
            ".".join(platform.python_version_tuple()[:2]),
            tuple(_libraries()),
        )

    def differences(self, other: "Stamp") -> list[str]:
        """What of another stamp is not as here, in words: theirs, then ours."""
        pairs = [
            (PACKAGE.name, other.code, self.code),
            ("Python", other.python, self.python),
            *_pairs(other.folders, self.folders),
            *_pairs(other.libraries, self.libraries),
        ]
        return [
            f"{name} {theirs or 'missing'}, not {ours or 'missing'}"
            for name, theirs, ours in pairs
            if theirs != ours
        ]


def _pairs(
    theirs: Iterable[tuple[str, str]], ours: Iterable[tuple[str, str]]
) -> Iterator[tuple[str, str, str]]:
    there = dict(theirs)
    return ((name, there.get(name, ""), version) for name, version in ours)


def _libraries() -> Iterator[tuple[str, str]]:
    try:
        requirements = metadata.requires(PACKAGE.name) or []
    except metadata.PackageNotFoundError:
        return
    for requirement in sorted(requirements):
        name = re.match(r"[\w.-]+", requirement)
        if name and "extra ==" not in requirement:
            try:
                yield name[0], metadata.version(name[0])
            except metadata.PackageNotFoundError:
                yield name[0], ""


def _package_files() -> Iterator[tuple[str, Path]]:
    yield from _files(PACKAGE)
    yield from (
        (inside, CHECKOUT / name) for name, inside in BUNDLED.items() if (CHECKOUT / name).is_file()
    )


def _folder_digest(name: str) -> str:
    folder = CHECKOUT / name
    return _digest(_files(folder)) if folder.is_dir() else ""


def _files(folder: Path) -> Iterator[tuple[str, Path]]:
    for path in folder.rglob("*"):
        if path.is_file() and path.suffix != ".pyc":
            yield path.relative_to(folder).as_posix(), path


def _digest(files: Iterable[tuple[str, Path]]) -> str:
    whole = hashlib.sha256()
    for name, path in sorted(files):
        whole.update(name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return whole.hexdigest()[:_DIGITS]
