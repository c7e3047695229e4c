"""Build ``scalar/kernels/kernels.so`` with the package, in place, where a C compiler is found; without one the package runs on NumPy alone."""

import os
import shlex
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FLAGS = [
    "-std=gnu11",
    "-O3",
    "-fno-math-errno",
    "-ffp-contract=off",
    "-shared",
    "-fPIC",
]  # no fused products: same bytes everywhere; no error number, which would keep roots from being taken several at once


def checksum(folder: Path) -> int:
    """Return a number that changes with the C source in a folder, as ``scalar.kernels.checksum`` does, which is not installed yet."""
    found = 0
    for path in sorted([*folder.glob("*.h"), *folder.glob("*.c")]):
        found = zlib.crc32(path.read_bytes(), found)
    return found


def build(source: Path) -> Path | None:
    """Return the library built from a C file, beside it, or None where that cannot be done; an older one is removed then."""
    target = source.with_suffix(".so")
    compiler = shlex.split(os.environ.get("CC", "cc"))
    partial = target.with_suffix(f".{os.getpid()}.partial")
    define = f"-DSOURCE_CHECKSUM={checksum(source.parent)}u"
    try:
        if shutil.which(compiler[0]) is None:
            raise OSError(f"no C compiler ({compiler[0]})")
        command = [*compiler, *FLAGS, define, "-o", str(partial), str(source), "-lm"]
        subprocess.run(command, check=True, capture_output=True, text=True)
        partial.replace(target)
    except (OSError, subprocess.CalledProcessError) as error:
        said = str(getattr(error, "stderr", "") or error).strip()
        print(f"scalar: the compiled kernels are left out, NumPy serves instead: {said}", file=sys.stderr)
        partial.unlink(missing_ok=True)
        target.unlink(missing_ok=True)
        return None
    return target


class KernelsHook(BuildHookInterface):
    """Hatchling's hook: builds the library, and says that a wheel with it is one of this platform."""

    def initialize(self, version: str, build_data: dict) -> None:
        """Build, for wheels and for editable installs."""
        if self.target_name != "wheel":
            return
        root = Path(self.root)
        found = build(root / "scalar" / "kernels" / "kernels.c")
        if found is not None:
            build_data["pure_python"] = False
            build_data["infer_tag"] = True
            build_data["artifacts"].append(found.relative_to(root).as_posix())
