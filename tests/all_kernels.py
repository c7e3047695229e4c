"""Run the tests with the arithmetic of several processors, one after another: `make test-kernels`.

No test may depend on the processor. Which kernels a name stands for, and how one machine imitates others, is said in
``study.processors.kernels``. Arguments are those of pytest; exit status 1 if the tests fail with any of the kernels.
"""

import subprocess
import sys

from study.processors.kernels import KERNELS, environment, imitates


def main(arguments: list[str]) -> int:
    """Run pytest once for each of ``KERNELS``, print how each run ended, and return the exit status."""
    ends = []
    for name in KERNELS:
        if not imitates(name):
            ends.append((name, "not run: this machine cannot imitate it", 1))
            continue
        print(f"== {name}", flush=True)
        status = subprocess.run(
            [sys.executable, "-m", "pytest", *arguments], env=environment(name), check=False
        ).returncode
        ends.append((name, "passed" if status == 0 else f"failed, exit status {status}", status))
    for name, end, _ in ends:
        print(f"{name}: {end}")
    return int(any(status for _, _, status in ends))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
