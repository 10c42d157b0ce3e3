"""Sixteen views with one defect of real scans at a time, through `relief run`: what is aligned, how near views and model come to the truth,
and how that compares with the same views without the defect and with what the defect leaves to be known."""

import json
import math
import shutil

from suite.measure import Failed, run
from suite.stages.merge import figures_of
from suite.rows import row
from suite.system import PYTHON, ROOT_PEERS

ROW_BY_ROW = True  # `measure` leaves out the rows of an earlier run by itself.
CLEAN = "clean"
NOISE = 0.3  # Range noise of the clean views [spacings]: the default of `relief simulate`.

# name -> options of `relief simulate`, and how its bound is found (a method of Bounds).
DEFECTS = {
    CLEAN: ((), "none"),
    "15 % missing": (("--missing", 0.15), "fewer_samples"),
    "plate behind": (("--background",), "none"),
    "normals upside down": (("--wrong-normals", "flip-y"), "none"),
    "normals upside down, undeclared": (("--wrong-normals", "flip-y", "--undeclared-normals"), "none"),
    "glare": (("--glare",), "none"),
    "2 % outliers": (("--outliers", 0.02), "none"),
    "steps of 2": (("--quantisation", 2), "white_noise"),
    "steps of 4": (("--quantisation", 4), "white_noise"),
    "warp of 0.5": (("--view-warp", 0.5), "systematic"),
    "warp of 2": (("--view-warp", 2), "systematic"),
    "half 5 times as noisy": (("--noise-half", 5), "two_noises"),
    "focal length 0.5 % off": (("--focal-factor", 1.005), "systematic"),
    "scale 0.5 % off": (("--scale-factor", 1.005), "systematic"),
    "rgbd": (("--range-sensor", "rgbd"), "unknown"),
    "tof": (("--range-sensor", "tof"), "unknown"),
    "laser line": (("--range-sensor", "laser-line"), "unknown"),
}


def slug(name):
    return "".join(letter if letter.isalnum() else "-" for letter in name)


class Bounds:
    """What the lost information allows: depth RMS of views and RMS of the model [spacings], from runs of the same program on views
    that hold the same information in its plainest form, or from the defect itself."""

    def __init__(self, case, context, clean):
        self.case, self.context, self.clean = case, context, clean

    def of(self, options, kind):
        if "depth" not in self.clean or "model" not in self.clean:
            return {}
        try:
            return getattr(self, kind)(*options)
        except Failed:  # Of the bound alone; the figures of the defect stand.
            return {}

    def none(self, *_):
        """The defect destroys nothing."""
        return {"depth": self.clean["depth"], "model": self.clean["model"]}

    def unknown(self, *_):
        return {}

    def fewer_samples(self, _, fraction):
        return {key: self.clean[key] / math.sqrt(1 - fraction) for key in ("depth", "model")}

    def white_noise(self, _, step):
        """Steps have the variance step^2 / 12; they can at best act as white noise of that size."""
        return self.with_noise(math.sqrt(NOISE**2 + step**2 / 12))

    def two_noises(self, _, factor):
        """Views: half of the samples with either noise. The model averages views by their weights, half of which are the lesser."""
        noisy = self.with_noise(factor * NOISE)
        if not noisy:
            return {}
        gain = math.sqrt(2 / (1 + 1 / factor**2))
        return {"depth": math.sqrt((self.clean["depth"]**2 + noisy["depth"]**2) / 2), "model": self.clean["model"] * gain}

    def with_noise(self, noise):
        figures = by_relief(self.case, self.context, f"white noise {noise:.3g}", ("--range-noise", f"{noise:.6g}"))[1]
        return {key: figures[key] for key in ("depth", "model") if key in figures}

    def systematic(self, *options):
        """What rigid motions and averages leave of the defect, beside the clean views' own error; in the depth the motions themselves, which
        no views can tell from their poses."""
        folder = self.case.folder / "bounds"
        exact = ("--range-sensor", "exact", "--normal-sensor", "exact")
        grids = {}
        for name, more in (("exact", ()), (slug(options[0] + str(options[1])), options)):
            grids[name] = folder / f"{name}-grids"
            if not (grids[name] / "scan.json").exists():
                scans = folder / name
                simulate(self.case, self.context, scans, (*exact, *more, "--poses", "exact"))
                grids[name].mkdir(parents=True, exist_ok=True)
                self.context.relief.grids(scans / "scan.json", grids[name])
                shutil.rmtree(scans)
        _, output = run([PYTHON, ROOT_PEERS / "rigid_bound.py", *grids.values()], folder / f"{slug(options[0])}.log")
        left = json.loads(output)
        beside = lambda clean, more: math.sqrt(clean**2 + more**2)
        return {"depth": beside(self.clean["depth"], left["motion"]), "model": beside(self.clean["model"], left["model"])}


def simulate(case, context, folder, options):
    mesh = case.mesh()
    context.relief.simulate(folder, *([mesh] if mesh else []), *case.simulation, *options)


def by_relief(case, context, name, options):
    """Cost and figures of `relief run` with its defaults, with the errors of the scans as they came."""
    relief, folder = context.relief, case.folder / slug(name)
    scans, out = folder / "scans", folder / "run"
    simulate(case, context, scans, options)
    spacing = case.spacing
    figures = {"before": depth_figures(relief, scans / "scan.json", scans, spacing, folder / "before.log").get("depth")}
    try:
        cost = relief.cost(folder / "run.log", "run", scans / "scan.json", "-o", out, "--fresh")
    except Failed as failure:
        return failure, figures
    report = json.loads((out / "report.json").read_text()) if (out / "report.json").exists() else {}
    if "align" not in report:
        return Failed("relief run wrote no report of the alignment"), figures
    figures["aligned"] = sum(view["aligned"] for view in report["align"]["views"])
    figures["views"] = len(report["align"]["views"])
    figures.update(depth_figures(relief, out / "scan.json", scans, spacing, folder / "views.log"))
    if (out / "model.ply").exists():
        mesh = figures_of(case, relief, out / "model.ply", folder / "model.log")
        figures.update(model=mesh.get("measured", mesh["accuracy"])["rms"], back=mesh["completeness"]["rms"],
                       model_normals=mesh["completeness"]["normals"], closed=mesh["closed"], components=mesh["components"],
                       filled=mesh["filled"])
    shutil.rmtree(scans)
    return cost, figures


def depth_figures(relief, project, scans, spacing, log):
    """Of the views; nothing where their rays are not those of the truth, as with a wrong focal length."""
    try:
        report = relief.figures(log, "evaluate", project, "--truth", scans / "truth/scan.json")
    except Failed:
        return {}
    return {"depth": report["depth"]["rms"] / spacing, "normals": report["geometry_normals_deg"]["mean"]}


def measure(case, context):
    """A row at a time, so that a run that ends early keeps what it has."""
    clean = next((line for line in context.earlier if line["method"] == CLEAN), {})
    for name, (options, bound) in DEFECTS.items():
        wanted = not context.defects or name in context.defects or name == CLEAN
        if not wanted or any(line["method"] == name for line in context.earlier):
            continue
        cost, figures = by_relief(case, context, name, options)
        clean = figures if name == CLEAN else clean
        figures["ratio"] = ratios(figures, clean)
        figures["bound"] = ratios(Bounds(case, context, clean).of(options, bound), clean)
        yield row(case, name, cost, **figures)


def ratios(figures, clean):
    """Of depth and model against those of the clean views."""
    return {key: figures[key] / clean[key] for key in ("depth", "model") if figures.get(key) and clean.get(key)}
