"""Run the tests with the arithmetic of several processors, one after another: `make test-kernels`.

No test may depend on the processor. Which kernels a name stands for, and how one machine imitates others, is said in
``study.processors.kernels``. Arguments are those of pytest; exit status 1 if the tests fail with any of the kernels.
"""

import subprocess
import sys

from study.processors.kernels import KERNELS, environment

REPORT_KERNELS = "from study.processors.kernels import kernels_in_use; print(*sorted(kernels_in_use()))"


def main(arguments: list[str]) -> int:
    """Run pytest once for each of ``KERNELS``, print how each run ended, and return the exit status."""
    ends = []
    for name, kernels in KERNELS.items():
        surroundings = environment(name)
        asked = subprocess.run(
            [sys.executable, "-c", REPORT_KERNELS],
            env=surroundings,
            capture_output=True,
            text=True,
            check=True,
        )
        used = set(asked.stdout.split())
        if not used or not used <= kernels.names:
            ends.append((name, f"not run: this machine takes the kernels {asked.stdout.strip()}", 1))
            continue
        print(f"== {name}: OpenBLAS runs {asked.stdout.strip()}", flush=True)
        status = subprocess.run(
            [sys.executable, "-m", "pytest", *arguments], env=surroundings, check=False
        ).returncode
        ends.append((name, "passed" if status == 0 else f"failed, exit status {status}", status))
    for name, end, _ in ends:
        print(f"{name}: {end}")
    return int(any(status for _, _, status in ends))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
