"""The machine and the versions of the programs that are compared."""

import os
import pathlib
import re
import shutil
import subprocess

from suite.measure import available_memory_gb

PYTHON = "/usr/bin/python3"  # The distribution's, which alone sees the packaged Open3D.
ROOT_PEERS = pathlib.Path(__file__).resolve().parents[1] / "peers"


def first_line(command):
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return (done.stdout or done.stderr).strip().split("\n")[0] if done.returncode == 0 else ""


def package_version(package):
    """Upstream's version of an installed package of the distribution, or nothing."""
    version = first_line(["dpkg-query", "-W", "-f=${db:Status-Status} ${Version}", package])
    if not version.startswith("installed "):
        return ""
    version = version.split(" ", 1)[1].split(":")[-1]
    return re.split(r"[-+]", version)[0]


class Programs:
    """Which programs there are: name -> version, empty when it is not installed."""

    def __init__(self, relief):
        has_numpy = bool(first_line([PYTHON, "-c", "import numpy; print(numpy.__version__)"]))
        has_display = bool(shutil.which("xvfb-run"))
        self.versions = {
            "relief": first_line([relief, "--version"]).split(" ")[-1],
            "Open3D": first_line([PYTHON, "-c", "import open3d; print(open3d.__version__)"]),
            "PCL": package_version("pcl-tools") if has_numpy else "",
            "CloudCompare": package_version("cloudcompare") if has_numpy and has_display else "",
            "admesh": package_version("admesh"),
        }

    def has(self, name):
        return bool(self.versions[name])

    def sentence(self):
        return ", ".join(f"{name} {version or '(not installed)'}" for name, version in self.versions.items())


def machine():
    model = "unknown processor"
    with open("/proc/cpuinfo", encoding="utf-8") as cpuinfo:
        for line in cpuinfo:
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    with open("/etc/os-release", encoding="utf-8") as release:
        names = [line.split("=", 1)[1].strip().strip('"') for line in release if line.startswith("PRETTY_NAME=")]
    return (f"{model}, {os.cpu_count()} cores, {available_memory_gb():.0f} GiB, "
            f"{names[0] if names else 'unknown system'}")
