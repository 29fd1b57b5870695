"""Write the tables of docs/mutants.md from the campaigns in docs/data."""

from generated import DOCS, main_of_pages
from node_mutants import table
from node_mutants.results import KEPT, KEPT_HELD_OUT, KEPT_RUNS, read, read_runs


def render() -> str:
    """Mutants under the suite."""
    conditions, results = read(DOCS.parent / KEPT)
    return table.of_the_suite(results, conditions)


def render_held_out() -> str:
    """Mutants that no check was written after."""
    conditions, results = read(DOCS.parent / KEPT_HELD_OUT)
    return table.of_the_suite(results, conditions)


def render_runs() -> str:
    """Mutants in runs."""
    conditions, runs = read_runs(DOCS.parent / KEPT_RUNS)
    return table.of_the_runs(runs, conditions)


PAGES = {
    "mutants.md": {
        "draw_mutants.py": render,
        "draw_mutants.py: held out": render_held_out,
        "draw_mutants.py: runs": render_runs,
    }
}

if __name__ == "__main__":
    main_of_pages("draw_mutants.py", PAGES)
