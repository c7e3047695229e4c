"""A whole Slurm cluster on the loopback of one machine, from the programs of Debian's packages; nothing is installed, nothing outlives the block.

The programs are looked for on PATH and in /usr/sbin, or below ``SLURM_ROOT``, a folder that the packages were unpacked to (``dpkg -x``).
"""

from __future__ import annotations

import os
import secrets
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

PACKAGES = {
    "munge": ("munged",),
    "slurmctld": ("slurmctld",),
    "slurmd": ("slurmd", "slurmstepd"),
    "slurm-client": ("sbatch", "srun", "squeue", "scancel", "sinfo", "scontrol"),
}
"""Debian's packages, and the programs that are needed of each."""
STARTS_WITHIN = 60.0  # s, on a machine that has other things to do
CONF = """
ClusterName=scalar
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ctld_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={root}/munge.socket
StateSaveLocation={root}/state
SlurmdSpoolDir={root}/spool-%n
SlurmctldPidFile={root}/slurmctld.pid
SlurmdPidFile={root}/slurmd-%n.pid
SlurmctldLogFile={root}/slurmctld.log
SlurmdLogFile={root}/slurmd-%n.log
{plugins}
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/filetxt
JobCompLoc={root}/jobs.txt
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
ReturnToService=2
SlurmdTimeout=20
InactiveLimit=0
KillWait=5
MinJobAge=3600
SchedulerParameters=sched_interval=2
{nodes}
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class MissingPackages(Exception):
    """Programs are not there; the message names the packages that hold them."""


def find_programs(root: Path | None) -> dict[str, Path]:
    """Return where each program is; Debian adds ``-wlm`` to some names.

    Raises:
        MissingPackages: One is nowhere.
    """
    prefix = root or Path("/")
    places = [prefix / "usr/sbin", prefix / "usr/bin"]
    if root is None:
        places = [*map(Path, os.environ.get("PATH", "").split(os.pathsep)), *places]
    found: dict[str, Path] = {}
    missing = []
    for package, programs in PACKAGES.items():
        for program in programs:
            names = [place / name for place in places for name in (program, f"{program}-wlm")]
            path = next((path for path in names if os.access(path, os.X_OK)), None)
            if path is None:
                missing.append(f"{package} (no {program})")
                break
            found[program] = path.resolve()
    if missing:
        raise MissingPackages(
            f"test-slurm needs Debian's packages {', '.join(missing)}: apt-get install slurm-wlm munge, or unpack them with dpkg -x "
            "and say SLURM_ROOT=FOLDER; nothing was installed, and nothing was tested"
        )
    return found


@dataclass
class Cluster:
    """A cluster that runs.

    Attributes:
        root: Its folder, with logs and configuration.
        environment: For programs that use it.
        programs: Where each is.
        nodes: The process of each node, by name.
    """

    root: Path
    environment: dict[str, str]
    programs: dict[str, Path]
    nodes: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)

    def run(self, program: str, *arguments: str) -> str:
        """Return what a client program prints."""
        done = subprocess.run(
            [self.programs[program], *arguments],
            env=self.environment,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise RuntimeError(f"{program}: {done.stderr.strip()}")
        return done.stdout

    def start_node(self, name: str) -> None:
        """Start a node, with nothing of an earlier life on its disk, and wait until the controller knows it."""
        spool = self.root / f"spool-{name}"
        shutil.rmtree(spool, ignore_errors=True)
        spool.mkdir()
        self.nodes[name] = subprocess.Popen(
            [self.programs["slurmd"], "-D", "-N", name, "-d", self.programs["slurmstepd"]],
            env=self.environment,
            stdout=open(self.root / f"{name}.out", "wb"),
            stderr=subprocess.STDOUT,
        )
        wait_for(lambda: "idle" in self.run("sinfo", "-h", "-n", name, "-o", "%t"), f"node {name}", self.root)

    def kill_node(self, name: str) -> None:
        """Kill a node and everything that runs on it, and tell the controller, which else finds out by itself after a while."""
        node = self.nodes.pop(name)
        jobs = [job for job, where in self.jobs() if where == name]
        node.kill()
        node.wait()
        for pid in self._of_node(name, jobs):
            kill_process(pid)
        self.run("scontrol", "update", f"nodename={name}", "state=down", "reason=killed")

    def _of_node(self, name: str, jobs: Sequence[str]) -> list[int]:
        """Return the ids of the processes of a node's jobs, and of the ``slurmstepd`` that watch them.

        Processes of jobs have the name of their node in their environment. A ``slurmstepd`` is known by its title, which begins with the job:
        the daemons of other nodes also have the word among their arguments.
        """
        found = []
        for folder in Path("/proc").iterdir():
            try:
                content = (folder / "environ").read_bytes() if folder.name.isdecimal() else b""
                title = (folder / "cmdline").read_bytes() if folder.name.isdecimal() else b""
            except OSError:
                continue
            mine = str(self.root).encode()
            if f"SLURMD_NODENAME={name}".encode() in content.split(b"\0") and mine in content:
                found.append(int(folder.name))
            elif mine in content and any(title.startswith(f"slurmstepd: [{job}.".encode()) for job in jobs):
                found.append(int(folder.name))
        return found

    def jobs(self, state: str = "RUNNING") -> list[tuple[str, str]]:
        """Return the number and the node of each job in a state."""
        lines = self.run("squeue", "-h", "-t", state, "-o", "%i %N").splitlines()
        return [(line.split()[0], [*line.split(), ""][1]) for line in lines]


def kill_process(pid: int) -> None:
    """Kill a process that may have ended already."""
    try:
        os.kill(pid, 9)
    except ProcessLookupError:
        return


def wait_for(condition: object, what: str, root: Path) -> None:
    """Wait until a condition holds; an error while it is looked at counts as not yet.

    Raises:
        RuntimeError: It does not hold in time; with the last lines of the logs.
    """
    assert callable(condition)
    until = time.monotonic() + STARTS_WITHIN
    while time.monotonic() < until:
        try:
            if condition():
                return
        except (RuntimeError, OSError):
            pass
        time.sleep(0.3)
    logs = [
        f"{path.name}: {path.read_text(errors='replace')[-600:]}"
        for path in sorted(root.glob("*.[lo][ou][gt]"))
    ]
    raise RuntimeError(f"{what} did not come up within {STARTS_WITHIN:.0f} s\n" + "\n".join(logs))


@contextmanager
def cluster(root: Path, nodes: Sequence[str], cores: int) -> Iterator[Cluster]:
    """Run a cluster of some nodes, each with some cores, while the block runs.

    Args:
        root: An empty folder with a short path, for sockets.
        nodes: Their names.
        cores: Of each node.

    Raises:
        MissingPackages: Programs are not there.
    """
    unpacked = Path(os.environ["SLURM_ROOT"]).resolve() if "SLURM_ROOT" in os.environ else None
    programs = find_programs(unpacked)
    environment = {**os.environ, "SLURM_CONF": str(root / "slurm.conf")}
    bin_folder = root / "bin"
    bin_folder.mkdir()
    for name, path in programs.items():
        # A job's environment does not have SLURM_CONF, and srun within a job looks for it.
        program = bin_folder / name
        program.write_text(f'#!/bin/sh\nSLURM_CONF="{root}/slurm.conf" exec "{path}" "$@"\n')
        program.chmod(0o755)
    environment["PATH"] = f"{bin_folder}:{environment['PATH']}"
    plugins = ""
    if unpacked is not None:
        libraries = unpacked / "usr/lib/x86_64-linux-gnu"
        environment["LD_LIBRARY_PATH"] = f"{libraries}:{libraries / 'slurm-wlm'}"
        plugins = f"PluginDir={libraries / 'slurm-wlm'}"
    ports = [_free_port() for _ in range(len(nodes) + 1)]
    host = socket.gethostname()
    import getpass

    lines = "\n".join(
        f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs={cores} RealMemory=4000 State=UNKNOWN"
        for name, port in zip(nodes, ports[1:], strict=True)
    )
    (root / "state").mkdir()
    (root / "slurm.conf").write_text(
        CONF.format(
            root=root, host=host, ctld_port=ports[0], user=getpass.getuser(), nodes=lines, plugins=plugins
        )
    )
    (root / "munge.key").write_bytes(secrets.token_bytes(128))
    (root / "munge.key").chmod(0o600)
    started: list[subprocess.Popen[bytes]] = []
    running = Cluster(root, environment, programs)
    try:
        started.append(
            _start(
                running, "munged", "--foreground", "--force", f"--socket={root}/munge.socket", f"--key-file={root}/munge.key",
                f"--pid-file={root}/munged.pid", f"--log-file={root}/munged.log", f"--seed-file={root}/munge.seed",
            )
        )  # fmt: skip
        wait_for((root / "munge.socket").exists, "munged", root)
        started.append(_start(running, "slurmctld", "-D", "-i"))
        wait_for(lambda: "scalar" in running.run("scontrol", "show", "config"), "slurmctld", root)
        for name in nodes:
            running.start_node(name)
        yield running
    finally:
        for process in (*running.nodes.values(), *started[::-1]):
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _start(running: Cluster, program: str, *arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [running.programs[program], *arguments],
        env=running.environment,
        stdout=open(running.root / f"{program}.out", "wb"),
        stderr=subprocess.STDOUT,
    )


def _free_port() -> int:
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return int(listening.getsockname()[1])


def copy_logs(root: Path, to: Path) -> None:
    """Keep the logs of a cluster."""
    to.mkdir(parents=True, exist_ok=True)
    for path in (*root.glob("*.log"), *root.glob("*.out"), root / "slurm.conf", root / "jobs.txt"):
        if path.exists():
            shutil.copy(path, to)
