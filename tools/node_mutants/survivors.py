"""Why the suite does not kill a mutant, and why the master does not stop one: by their names."""

from typing import Final

EQUIVALENT: Final = "equivalent"
"""On the bus it does what the code as it is does: to the frame, or to less than a count."""
GAP: Final = "gap"
"""It does not, and no check asks."""

SURVIVED_FOR: Final[dict[str, tuple[str, str]]] = {}

MISSED: Final[dict[str, str]] = {}
