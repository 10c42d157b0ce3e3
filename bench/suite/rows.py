"""One line of a table: which method on which case, what it cost, how good it was."""

from dataclasses import asdict

from suite.measure import Cost


def row(case, method, cost, **figures):
    """`cost` is a Cost, None for what costs nothing, or the Exception of a program that failed."""
    line = {"case": case.name, "method": method, "spacing": case.spacing, "unit": case.unit}
    if isinstance(cost, Exception):
        line["failed"] = str(cost)
    elif cost is not None:
        line["cost"] = asdict(cost)
        line["cost"]["commands"] = [" ".join(str(word) for word in command) for command in cost.commands]
    line.update(figures)
    return line


def not_installed(case, method):
    return {"case": case.name, "method": method, "missing": True}


def cost_of(line):
    return Cost(**line["cost"])
