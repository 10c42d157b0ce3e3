"""The named cases: what is scanned, and what is known of the truth."""

import json
import os
import pathlib
from dataclasses import dataclass, field

from suite.measure import run
from suite.real_sets import icl_nuim
from suite.system import PYTHON, ROOT_PEERS

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_data():
    """Folder of the real scans and meshes; it may be absent."""
    return pathlib.Path(os.environ.get("RELIEF_TEST_DATA", ROOT.parent / "shared" / "data"))


@dataclass
class Case:
    name: str
    title: str
    """What a table's reader needs to know."""
    stages: tuple
    """Which tables it is in."""
    source: str = ""
    """Real scans: the project below the data folder. Simulated ones: the mesh below it; empty: the built-in object."""
    options: tuple = ()
    """Simulated: options of `relief simulate`. Real: of every command that reads the project."""
    smoothed: int = 0
    """Simulated: how many times the faces of the mesh are divided, smoothly, before it is scanned."""
    simulated: bool = False
    truth_views: str = ""
    truth_poses: str = ""
    truth_mesh: str = ""
    """Below the data folder; set by `prepare` for simulated scans."""
    disturbed: tuple = ()
    """Real scans: degrees that poses are turned by, and the share of the object's size that they are moved by."""
    slow_peers: bool = False
    """Whether peers that take minutes are run on it."""
    starts: tuple = ("given",)
    """Stage `real`: the poses it is started from: `given`, `off` (by the pair `off`: degrees, and a length in its unit), `none`."""
    off: tuple = ()
    seeds: int = 1
    """How many random starts of each kind."""
    single: bool = False
    """Whether it is a single view: nothing to align."""
    room: bool = False
    """Whether it is a room in metres, seen by a depth camera in small steps."""
    make: object = None
    """Writes the project of a set that is none: takes the source and a folder, returns its file."""
    simulation: tuple = ()
    """Simulated: the options it was simulated with, set by `prepare`."""
    folder: pathlib.Path = None
    project: pathlib.Path = None
    spacing: float = 0.0
    unit: str = "mm"
    cached: dict = field(default_factory=dict)

    def available(self):
        return not self.source or (test_data() / self.source).exists()

    def prepare(self, relief, output):
        """Simulates the scans, or finds the real ones."""
        self.folder = output / self.name
        self.folder.mkdir(parents=True, exist_ok=True)
        if self.simulated:
            scans = self.folder / "scans"
            mesh = self.mesh()
            relief.simulate(scans, *([mesh] if mesh else []), *self.options)
            self.project = scans / "scan.json"
            self.truth_views, self.truth_poses = scans / "truth/scan.json", scans / "truth.json"
            self.truth_mesh = mesh or scans / "truth/model.ply"
            self.simulation, self.options = self.options, ()
        else:
            self.project = test_data() / self.source
            if self.make:
                self.project = self.make(self.project, self.folder / "project")
            for name in ("truth_poses", "truth_mesh"):
                if getattr(self, name):
                    setattr(self, name, test_data() / getattr(self, name))
            self.options = tuple(test_data() / word if word.endswith(".fc") else word for word in self.options)
            if self.disturbed:
                self.project = self.at_disturbed_poses(relief)
        self.spacing = relief.spacing(self.input(), self.folder / "info.log")

    def mesh(self):
        """That is scanned; none: the built-in object."""
        if not self.smoothed:
            return test_data() / self.source if self.source else None
        mesh = self.folder / "smoothed.ply"
        run([PYTHON, ROOT_PEERS / "smoothed.py", test_data() / self.source, self.smoothed, mesh], self.folder / "smoothed.log")
        return mesh

    def at_disturbed_poses(self, relief):
        grids = self.folder / "disturbed"
        grids.mkdir(exist_ok=True)
        relief.grids(self.project, grids)
        run([PYTHON, ROOT_PEERS / "disturb.py", grids, *self.disturbed, grids / "disturbed.json"], self.folder / "disturb.log")
        return grids / "disturbed.json"

    def input(self):
        return [self.project, *self.options]


def with_poses(project, poses, output):
    """Writes a copy of a project file with other poses (name -> 4x4), beside the original: its file names stay valid."""
    document = json.loads(pathlib.Path(project).read_text())
    for view in document["views"]:
        view["world_from_view"] = poses[view["name"]]
        view["pose_is"] = "known"
    output = pathlib.Path(project).with_name(output)
    output.write_text(json.dumps(document))
    return output


def poses_of(path):
    """name -> 4x4 of a project or of a list of poses."""
    return {view["name"]: view["world_from_view"] for view in json.loads(pathlib.Path(path).read_text())["views"]}


SIXTEEN = ("--views", "16", "--seed", "5")
PHOTOMETRIC = ("--normal-sensor", "photometric-stereo")
SIMULATED = ("refine", "align", "merge", "chain")
FIVE = {"seeds": 5, "starts": ("given", "off", "none"), "off": (4, 0.002), "unit": "m"}
""""Off" of the raw Cyberware sets: 4 degrees and 2 mm."""


def real_sets():
    """Stage `real`: every real set that has views."""
    real = ("real",)
    return [
        Case("bunny-real", "Stanford bunny, 10 raw Cyberware scans, published poses", real, "bunny/bun.conf", slow_peers=True, **FIVE),
        Case("dragon-real", "Stanford dragon, 15 raw Cyberware scans, published poses", real, "dragon/dragonStandRight.conf", **FIVE),
        Case("bear-real", "bear, 20 views, normals from photographs, range simulated on a reconstructed mesh, poses off by 2°", real,
             "bear/scan.json", truth_poses="bear/truth.json"),
        Case("kinect-real", "a room, 5 views of a depth camera (PCL's registration tutorial), no poses", real, "kinect", unit="m",
             room=True, starts=("none",)),
        Case("rgbd-real", "a room, 5 rendered depth images (ICL-NUIM) with a trajectory", real, "rgbd", unit="m", room=True, make=icl_nuim),
        Case("panel-real", "panel of Nehab et al. 2005, one view with measured normals", real, "panel/panel-small-conf.ply",
             options=("--fc", "panel/panel-small.fc"), single=True),
    ]


def hard_objects(quick):
    """Stage `hard`: what the defects are simulated on."""
    hard = ("hard",)
    if quick:
        return [Case("owl-hard", "built-in object, 8 views of 192x192", hard, simulated=True,
                     options=("--views", "8", "--width", "192", "--height", "192", "--mesh-divisions", "128", "--seed", "5"))]
    return [Case("owl-hard", "built-in object, 16 views of 512x512", hard, simulated=True, options=SIXTEEN),
            Case("lion-hard", "lion statue, 16 views of 512x512", hard, "meshes/lionstatue.obj", simulated=True, options=SIXTEEN),
            Case("falcon-hard", "falcon statue, 16 views of 512x512", hard, "meshes/falconstatue.obj", simulated=True,
                 options=SIXTEEN)]


def all_cases(quick):
    if quick:
        size = ("--width", "192", "--height", "192", "--mesh-divisions", "128")
        return [Case("owl", "built-in object, 12 views of 192x192", SIMULATED, simulated=True, slow_peers=True,
                     options=size), *hard_objects(quick)]
    return [
        Case("owl", "built-in object, 12 views of 512x512, white noise of positions, normals of 1.5° noise and 4° smooth bias",
             SIMULATED, simulated=True, slow_peers=True),
        Case("scanner", "built-in object, 12 views of 512x512, a structured-light scanner with photometric stereo: correlated and "
             "quantised range, dark patches, flying samples, calibration warp, shadows and highlights", SIMULATED, simulated=True,
             options=("--range-sensor", "structured-light", *PHOTOMETRIC)),
        Case("laser-line", "the same object through the simulator's laser-line scanner, rays of two centres, with photometric stereo",
             ("merge", "chain"), simulated=True, options=("--range-sensor", "laser-line", "--rays", "line", *PHOTOMETRIC)),
        Case("rgbd", "the same object through the simulator's RGB-D camera with photometric stereo", ("merge", "chain"), simulated=True,
             options=("--range-sensor", "rgbd", *PHOTOMETRIC)),
        Case("tof", "the same object through the simulator's time-of-flight camera, multipath included, with photometric stereo",
             ("merge", "chain"), simulated=True, options=("--range-sensor", "tof", *PHOTOMETRIC)),
        Case("lion", "lion statue, 12 simulated views of 512x512", SIMULATED, "meshes/lionstatue.obj",
             simulated=True),
        Case("falcon", "falcon statue, 12 simulated views of 512x512", SIMULATED, "meshes/falconstatue.obj",
             simulated=True),
        Case("bear", "bear, 20 views of 612x512, normals from photographs (DiLiGenT-MV), range simulated on a "
             "reconstructed mesh", ("align", "merge", "chain", "fit"), "bear/scan.json",
             truth_poses="bear/truth.json", truth_mesh="bear/reference.ply"),
        Case("bunny", "Stanford bunny, 10 raw Cyberware scans without normals, published poses", ("merge", "chain"),
             "bunny/bun.conf", truth_mesh="bunny/reference.ply", unit="m"),
        Case("bunny-off", "the same scans from poses off by 2° and 1 % of the size; errors are against the published poses, themselves "
             "a registration", ("align",), "bunny/bun.conf", truth_poses="bunny/bun.conf", unit="m", disturbed=(2, 0.01)),
        Case("owl16", "built-in object, 16 views of 512x512", ("sixteen",), simulated=True, options=SIXTEEN),
        Case("lion16", "lion statue, 16 views of 512x512", ("sixteen",), "meshes/lionstatue.obj", simulated=True,
             options=SIXTEEN),
        Case("falcon16", "falcon statue, 16 views of 512x512", ("sixteen",), "meshes/falconstatue.obj", simulated=True,
             options=SIXTEEN),
        Case("lion16-smooth", "the lion's faces divided twice by Loop's scheme", ("sixteen",), "meshes/lionstatue.obj", smoothed=2,
             simulated=True, options=SIXTEEN),
        Case("falcon16-smooth", "the falcon's faces divided likewise", ("sixteen",), "meshes/falconstatue.obj", smoothed=2,
             simulated=True, options=SIXTEEN),
        Case("panel", "panel of Nehab et al. 2005, one view of 512x384 with measured normals", ("fit",),
             "panel/panel-small-conf.ply", options=("--fc", "panel/panel-small.fc")),
        *real_sets(), *hard_objects(quick),
    ]
