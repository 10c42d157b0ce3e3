"""Slurm in a folder of its own, whose nodes are daemons on this machine: munged, slurmctld and a slurmd per node.

Needs the packages slurm-wlm and munge, and root: slurmd takes the user of each job.
"""
import os
import re
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path

CONFIGURATION = """
ClusterName=local
SlurmctldHost={host}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
SlurmctldPort=16817
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=1
JobAcctGatherParams=OverMemoryKill
MpiDefault=none
ReturnToService=2
MinJobAge=300
SlurmdTimeout=15
SchedulerParameters=batch_sched_delay=0,sched_interval=1
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


MEMORY = 5000  # Of a node [MB].


def available():
    programs = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol")
    return os.geteuid() == 0 and all(shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin") for name in programs)


class SlurmNodes:
    """Runs while the `with` block does. `environment` is that of its clients. Nodes have one core and `memory` MB each."""

    def __init__(self, folder, nodes=4, memory=MEMORY):
        self.folder = Path(folder).resolve()
        self.names, self.memory = [f"n{k}" for k in range(1, nodes + 1)], memory
        self.environment = {"SLURM_CONF": str(self.folder / "slurm.conf")}
        self.daemons = {}

    def start(self, name, *command):
        path = os.environ["PATH"] + ":/usr/sbin"
        program = shutil.which(command[0], path=path)
        with open(self.folder / f"{name}.out", "a") as log:
            self.daemons[name] = subprocess.Popen([program, *command[1:]], stdout=log, stderr=log,
                                                  env=dict(os.environ, PATH=path, **self.environment))

    def start_controller(self, *more):
        self.start("slurmctld", "slurmctld", "-D", "-f", self.environment["SLURM_CONF"], *more)

    def start_node(self, name):
        self.start(name, "slurmd", "-D", "-N", name, "-f", self.environment["SLURM_CONF"])

    def end(self, name):
        daemon = self.daemons.pop(name)
        daemon.kill()
        daemon.wait()

    def kill_node(self, name):
        """As if its power were cut: the daemon and all processes of its jobs. The number of jobs that worked there."""
        self.end(name)
        processes = of_node(name)
        supervisors = {parent_of(process) for process in processes} - set(processes) - {1}
        for process in [*supervisors, *processes]:
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
        return len(supervisors)

    def configuration(self):
        host = socket.gethostname().split(".")[0]
        text = CONFIGURATION.format(host=host, folder=self.folder)
        for k, name in enumerate(self.names):
            (self.folder / f"spool-{name}").mkdir(exist_ok=True)
            text += f"NodeName={name} NodeHostname={host} Port={16821 + k} CPUs=1 RealMemory={self.memory} State=UNKNOWN\n"
        return text

    def __enter__(self):
        for name in ("state", "munge"):
            (self.folder / name).mkdir(parents=True, exist_ok=True)
        munge = self.folder / "munge"
        munge.chmod(0o700)
        (munge / "key").unlink(missing_ok=True)
        (munge / "key").write_bytes(os.urandom(1024))
        (munge / "key").chmod(0o400)
        (self.folder / "slurm.conf").write_text(self.configuration())
        self.start("munged", "munged", "--foreground", "--force", f"--key-file={munge}/key", f"--socket={munge}/socket",
                   f"--pid-file={munge}/pid", f"--log-file={munge}/log", f"--seed-file={munge}/seed")
        time.sleep(1)
        self.start_controller("-c")
        for name in self.names:
            self.start_node(name)
        for _ in range(60):
            if self.client("sinfo", "--noheader", "--Node", "--format=%t").split() == ["idle"] * len(self.names):
                return self
            time.sleep(0.5)
        self.__exit__()
        raise RuntimeError(f"Slurm does not start: see the logs in {self.folder}")

    def ended_for_memory(self):
        """How many jobs took more memory than they had asked for."""
        ended = set()
        for log in self.folder.glob("slurmd-*.log"):
            ended.update(re.findall(r"StepId=(\d+)\S* exceeded memory limit", log.read_text()))
        return len(ended)

    def client(self, *command):
        return subprocess.run(command, env=dict(os.environ, **self.environment), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              text=True).stdout

    def __exit__(self, *_):
        self.client("scancel", "--user=root")
        for name in reversed(list(self.daemons)):
            daemon = self.daemons[name]
            daemon.terminate()
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()


def processes_where(entry, matches):
    """Ids of the processes whose words in /proc/ID/`entry` (cmdline, environ) match."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if matches((folder / entry).read_bytes().split(b"\0")):
                found.append(int(folder.name))
        except OSError:
            continue
    return found


def of_node(name):
    """Process ids of what jobs run on a node."""
    return processes_where("environ", lambda words: f"SLURMD_NODENAME={name}".encode() in words)


def parent_of(process):
    try:
        return int(Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[1])
    except OSError:
        return 1
