"""The commands of relief that the suite measures or uses, each as one call."""

import json
import pathlib

from suite.measure import run

STEPS = ["align", "calibrate", "compare", "refine", "align-again", "merge", "polish", "finish"]
"""Of `relief run`, as `relief step` takes them, in their order."""


class Relief:
    def __init__(self, executable):
        self.executable = pathlib.Path(executable).resolve()

    def command(self, name, *arguments):
        return [self.executable, name, *arguments]

    def cost(self, log, name, *arguments):
        """Cost of one command. Status 1, the data does not allow all of it, is left to the evaluation to judge."""
        cost, _ = run(self.command(name, "-q", *arguments), log, statuses=(0, 1))
        return cost

    def figures(self, log, name, *arguments):
        """What a command reports as JSON."""
        _, output = run(self.command(name, "-q", "--json", *arguments), log)
        return json.loads(output)[name]

    def simulate(self, folder, *arguments):
        run(self.command("simulate", "-q", *arguments, "-o", folder), folder / "simulate.log")

    def grids(self, project, folder):
        """The views of a project as grid files, which peers read after `clouds.py`."""
        run(self.command("convert", "-q", "--grids", project, "-o", folder), folder / "convert.log")

    def spacing(self, inputs, log):
        """Median over the views of their sample spacing."""
        spacings = sorted(view["spacing"] for view in self.figures(log, "info", *inputs)["views"])
        return spacings[len(spacings) // 2]
