"""List the checks of ``rfms conform`` in docs/conform.md."""

from generated import main, table

from rfms_can.conform.table import CHECKS, Check


def row(check: Check) -> tuple[str, ...]:
    """A check as a row."""
    asked = "pending" if check.run is None else "required" if check.required else "recommended"
    return check.id, check.kind.value, asked, check.title, check.want


def render() -> str:
    """The table of checks."""
    columns = ("check", "class", "", "what is done", "what must come")
    return "## Checks\n\n" + table(columns, [row(check) for check in CHECKS])


if __name__ == "__main__":
    main("draw_conform.py", "conform.md", render)
