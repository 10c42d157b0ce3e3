"""Runs programs and measures what they cost."""

import os
import pathlib
import resource
import signal
import subprocess
import threading
import time
from dataclasses import dataclass, field


@dataclass
class Cost:
    """What one or several processes took. Times in seconds, with everything a process does: starting, reading,
    computing, writing, and its children."""
    wall: float = 0.0
    processor: float = 0.0
    peak_mb: float = 0.0
    commands: list = field(default_factory=list)

    def __add__(self, other):
        return Cost(self.wall + other.wall, self.processor + other.processor,
                    max(self.peak_mb, other.peak_mb), self.commands + other.commands)


class Failed(Exception):
    """A program did not do its work; the message says which, how, and where its messages are."""


# Threads of OpenMP that wait sleep: spinning would count as work, and on a machine that does other work as well slows
# Open3D and PCL several times.
ENVIRONMENT = {**os.environ, "OMP_WAIT_POLICY": "passive"}


def run(command, log, cwd=None, timeout=1800, statuses=(0,)):
    """Runs `command`, its messages into the file `log`; returns its cost and its standard output."""
    command = [str(word) for word in command]
    log = pathlib.Path(log)
    log.parent.mkdir(parents=True, exist_ok=True)
    output = log.with_suffix(".out")
    with open(output, "wb") as out, open(log, "wb") as err:
        start = time.monotonic()
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, cwd=cwd,
                                 env=ENVIRONMENT, start_new_session=True)
        late = threading.Timer(timeout, os.killpg, (child.pid, signal.SIGKILL))
        late.start()
        try:
            _, status, usage = os.wait4(child.pid, 0)
        except BaseException:
            os.killpg(child.pid, signal.SIGTERM)
            raise
        finally:
            late.cancel()
        wall = time.monotonic() - start
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode not in statuses:
        raise Failed(f"{' '.join(command)}: exit status {child.returncode}; see {log}")
    cost = Cost(wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, [command])
    return cost, output.read_text(errors="replace")


SHORT = 5.0  # seconds


def cheapest(methods, rounds):
    """Calls each function of `methods` (name -> function that returns a Cost) once; those that took less than SHORT
    again, `rounds` times in all, in turns, so that a busy moment of the machine hits all alike. Returns the cost of least processor time
    of each; a function that fails has its exception instead."""
    best = {}
    for turn in range(rounds):
        for name, method in methods.items():
            if turn > 0 and (isinstance(best[name], Exception) or best[name].wall > SHORT):
                continue
            try:
                cost = method()
            except Failed as failure:
                best[name] = failure
                continue
            if turn == 0 or cost.processor < best[name].processor:
                best[name] = cost
    return best


def available_memory_gb():
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30


def limit_core_dumps():
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
