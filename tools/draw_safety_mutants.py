"""Write the tables of docs/safety-mutants.md from the campaign in docs/data."""

from generated import DOCS, main_of_pages
from safety_mutants import table
from safety_mutants.results import KEPT, SAFETY


def render() -> str:
    """Mutants of the safety core under its tests."""
    conditions, results = SAFETY.read(DOCS.parent / KEPT)
    return table.of_the_campaign(results, conditions)


PAGES = {"safety-mutants.md": {"draw_safety_mutants.py": render}}

if __name__ == "__main__":
    main_of_pages("draw_safety_mutants.py", PAGES)
