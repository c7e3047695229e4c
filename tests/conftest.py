"""Settings that hold for every test, before NumPy or Matplotlib is imported anywhere."""

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"  # same seed, same bytes, on one core or two
os.environ["MPLBACKEND"] = "Agg"  # no test opens a window
# Many tests start Python again, a workflow some hundred times: each would compile all imports anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from hypothesis import settings  # noqa: E402

# No deadline: a machine that is busy is not a failing law. By hand the examples differ from run to run, and
# so find more; where CI is set they are the same each time, so that a red run stays red.
settings.register_profile("by-hand", deadline=None, print_blob=True)
settings.register_profile("ci", parent=settings.get_profile("by-hand"), derandomize=True, database=None)
settings.load_profile("ci" if os.environ.get("CI") else "by-hand")


def pytest_collection_modifyitems(items):
    """Put files with slow tests first: where two workers share the files, neither is left alone with a long one at the end."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)
