"""Imitate the arithmetic of other processors on one machine.

NumPy and SciPy bring OpenBLAS, which takes kernels made for the processor it runs on, and NumPy has loops of its own for
processors with wider registers. Kernels add in different orders, and so results differ in their last bits. Two variables of a
process's environment choose for it: ``OPENBLAS_CORETYPE`` the kernels of both OpenBLAS libraries, ``NPY_DISABLE_CPU_FEATURES``
the registers that NumPy's loops may not use.

Assumption: the machine has AVX-512; one that has not cannot imitate ``SkylakeX``. Left out: processors that are not x86, and other
builds of BLAS.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

OPENBLAS, NUMPY = "OPENBLAS_CORETYPE", "NPY_DISABLE_CPU_FEATURES"


@dataclass(frozen=True)
class Kernels:
    """The arithmetic of a processor.

    Attributes:
        names: By which OpenBLAS calls the kernels that it then runs. The wheels of NumPy and SciPy hold no kernels of their own for
            Prescott's namesakes and for Zen, and take those of the first name that stands for the same.
        avx2, avx512: Whether NumPy may use these registers.
    """

    names: frozenset[str]
    avx2: bool
    avx512: bool


KERNELS = {
    "Prescott": Kernels(frozenset({"Prescott", "Katmai"}), avx2=False, avx512=False),
    "Haswell": Kernels(frozenset({"Haswell"}), avx2=True, avx512=False),
    "SkylakeX": Kernels(frozenset({"SkylakeX"}), avx2=True, avx512=True),
    "Zen": Kernels(frozenset({"Zen", "Haswell"}), avx2=True, avx512=False),
}
"""Processors by the name that ``OPENBLAS_CORETYPE`` takes."""


def environment(kernels: str) -> dict[str, str]:
    """Return the environment in which a process started from here calculates as on a processor, a key of ``KERNELS``."""
    wanted = KERNELS[kernels]
    import numpy as np

    config: Any = np.show_config("dicts")
    forbidden = [
        feature
        for feature in config["SIMD Extensions"].get("found", [])
        if not (wanted.avx512 if _is_avx512(feature) else wanted.avx2)
    ]
    return os.environ | {OPENBLAS: kernels, NUMPY: " ".join(forbidden)}


def _is_avx512(feature: str) -> bool:
    return feature.startswith("AVX512") or feature == "X86_V4"


def kernels_in_use() -> set[str]:
    """Return the names of the kernels that the OpenBLAS libraries of this process run."""
    import scipy.linalg  # noqa: F401  # brings a library of its own, beside NumPy's
    from threadpoolctl import threadpool_info  # of the workflow's extra

    return {library["architecture"] for library in threadpool_info() if library["internal_api"] == "openblas"}
