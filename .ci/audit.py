"""Ask pip-audit whether a vulnerability of a locked package is known: `make audit`.

The exit status is 1 if one is known, or if the answer is no table. It is 0 with a sentence where nothing could be asked, because the tool or the
network is missing: pip-audit itself ends with 0 if its database knows none of the packages, and that is no result.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

LOCK = Path(__file__).resolve().parents[1] / "requirements" / "lock.txt"
OPTIONS = ("--require-hashes", "--disable-pip", "--progress-spinner", "off", "--format", "json")
SECONDS = 600  # that the tool may take
_NO_NETWORK = (
    "Max retries exceeded",
    "Failed to resolve",
    "NewConnectionError",
    "ConnectionError",
    "timed out",
)


def judged(answer: str) -> tuple[int, str]:
    """Return the exit status and what to say about what pip-audit printed in JSON."""
    try:
        packages = json.loads(answer)["dependencies"]
        audited = [each for each in packages if "skip_reason" not in each]
        known = [(each["name"], each["version"], one["id"]) for each in audited for one in each["vulns"]]
    except (ValueError, KeyError, TypeError):
        return 1, "audit: pip-audit printed no table; run it by hand on requirements/lock.txt"
    if known:
        lines = [f"audit: {name} {version} has {identifier}" for name, version, identifier in known]
        return 1, "\n".join(lines)
    if not audited:
        return 0, (
            f"audit skipped: the database of vulnerabilities answered for none of {len(packages)} packages, so nothing is known about them; "
            "run this where it can be reached"
        )
    left = len(packages) - len(audited)
    rest = f"; {left} could not be looked up" if left else ""
    return 0, f"audit: no known vulnerability in {len(audited)} locked packages{rest}"


def audit() -> tuple[int, str]:
    """Return the exit status and what to say."""
    tool = shutil.which("pip-audit")
    if tool is None:
        return 0, "audit skipped: there is no pip-audit; install it, outside of .venv, and call this again"
    try:
        run = subprocess.run(
            [tool, "--requirement", str(LOCK), *OPTIONS],
            capture_output=True,
            text=True,
            check=False,
            timeout=SECONDS,
        )
    except subprocess.TimeoutExpired:
        return 0, f"audit skipped: no answer from the network within {SECONDS} s"
    if not run.stdout.strip() and any(sign in run.stderr for sign in _NO_NETWORK):
        return 0, "audit skipped: the database of vulnerabilities cannot be reached from here"
    return judged(run.stdout)


if __name__ == "__main__":
    status, said = audit()
    print(said)
    sys.exit(status)
