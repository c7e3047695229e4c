# make            set up .venv, then run the main job: snakemake --cores 2
# make test       set up .venv, then run the tests, a file at a time on each core
# make test-kernels   the tests four times, with the arithmetic of four processors
# make env        set up .venv alone; nothing is done if it is up to date
# make lint       ruff, pyright, snakefmt, snakemake --lint, the order of imports        make format   let ruff and snakefmt rewrite
# make docs       the documentation as a site, results/docs/index.html
# make docs-pictures  the pictures of effects that it shows, from simulated data (docs/pictures)
# make test-slurm  a sweep on a Slurm cluster that is started here, from Debian's packages
# make bench      the side-by-side figures       make lock     resolve the requirements again
# make bench-solvers   an environment with JAX, and the fit by it and by Ceres (Debian's libceres-dev) beside ours
# make bench-trackers  other calibration packages on tracker data, each in an environment of its own in .bench (1.8 GB)
# make lock-trackers   resolve the requirements of these packages again
# make readme-figures   copies of the figures that the README shows, from results/
# make audit      known vulnerabilities of the locked packages, by pip-audit; says so where that or the network is missing
# make release VERSION=0.3.0   set the version everywhere, and close the open section of the changelog
# make clean      remove the environments and the caches; results/ stays (snakemake --delete-all-output removes that)
#
# PYTHON=/path/to/python3.11, CORES=2 and PYTEST_ARGS="-k name" may be given.

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.PHONY: all env test test-kernels test-slurm lint format bench bench-solvers bench-trackers lock lock-trackers clean docs docs-pictures readme-figures release audit

SHELL := /bin/sh
CORES ?= 2
PYTEST_ARGS ?=
PYTHON ?= python3.11 python3 python

# One thread for BLAS: the same seed then gives the same bytes on any number of cores,
# and two jobs of a workflow do not fight for two cores.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export MKL_NUM_THREADS := 1

BIN := .venv/bin
# Jobs call `python` and `scalar` by name. Set for a recipe only, never for the search for Python below.
RUN = PATH="$(CURDIR)/$(BIN):$$PATH"

# The first of $(PYTHON) that is 3.11 and can make environments. `sys._base_executable`: if .venv is active,
# its python is found first, and must not be the one to build the next .venv.
find_python = $(shell for python in $(PYTHON); do "$$python" -c 'import sys, venv, ensurepip; \
	sys.version_info[:2] == (3, 11) or sys.exit(1); print(sys._base_executable)' 2>/dev/null && break; done)
found = $(or $(shell for python in $(PYTHON); do "$$python" -c 'import sys; \
	print("%s is" % sys.argv[1], sys.version.split()[0])' "$$python" 2>/dev/null && break; done),no Python)
no_python = scalar needs Python 3.11 with venv (the simulator has no wheels for later ones), but found: \
$(found). Install it, or say: make PYTHON=/path/to/python3.11

# A stamp is the last thing its recipe writes, and lies inside .venv: an environment that was only half built,
# or removed, has none. The lock rebuilds .venv from nothing, so that no package of an older lock stays behind.
LOCKED := .venv/.locked
INSTALLED := .venv/.installed
COMPILED := .venv/.compiled

env: $(COMPILED)

# Two `make` in one checkout: the second waits, and then finds that its work is done. The system releases the lock when its owner ends,
# however it ends. Without flock, as on macOS, they do not wait.
ONE_AT_A_TIME = exec 9>.venv.lock; if command -v flock >/dev/null; then flock 9; fi; \
	made() { for file in "$$@"; do test $@ -nt "$$file" || return 1; done; }

# uv is some seven times faster than pip here, but does not read pip's configuration (a mirror, a proxy).
# --compile-bytecode: where Python may not write bytecode (many containers), each start would compile all imports anew.
$(LOCKED): requirements/bootstrap.txt requirements/lock.txt
	@$(if $(find_python),,$(error $(no_python)))set -e; $(ONE_AT_A_TIME); if made $^; then exit 0; fi; \
	echo "Building .venv from requirements/lock.txt"; \
	python="$(find_python)"; rm -rf .venv; "$$python" -m venv .venv; \
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --only-binary :all: \
		-r requirements/bootstrap.txt; \
	$(BIN)/uv pip install --quiet --compile-bytecode --python $(BIN)/python --require-hashes --no-deps --no-build-isolation \
		-r requirements/lock.txt || \
	{ echo "uv could not install the lock; once more with pip" && \
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --no-deps \
		--no-build-isolation -r requirements/lock.txt; }; \
	touch $@

$(INSTALLED): $(LOCKED) pyproject.toml scalar/__init__.py hatch_build.py $(wildcard scalar/kernels/*.[ch])
	@set -e; $(ONE_AT_A_TIME); if made $^; then exit 0; fi; \
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-index --no-deps --no-build-isolation \
		--editable .; \
	touch $@

# Our own modules, for the same reason: those that changed since the stamp. Checked by a hash of the source, not by its time,
# so that no stale bytecode is ever run, whatever a checkout or an editor does to the times of files.
SOURCES := $(shell find scalar workflow/study -name '*.py' 2>/dev/null)
$(COMPILED): $(INSTALLED) $(SOURCES)
	@$(if $(filter %.py,$?),$(BIN)/python -m compileall -q -f --invalidation-mode checked-hash $(filter %.py,$?))
	@touch $@

all: env
	$(RUN) snakemake --cores $(CORES)

# A file stays in one process, so that what its tests share is made once.
PARALLEL = -n $(CORES) --dist loadfile --no-loadscope-reorder

test: env
	$(RUN) python -m pytest $(PARALLEL) $(PYTEST_ARGS)

test-kernels: env
	$(RUN) python -m tests.all_kernels $(PARALLEL) $(PYTEST_ARGS)

lint: env
	$(RUN) ruff check .
	$(RUN) ruff format --check .
	$(RUN) pyright
	$(RUN) snakefmt --check $(wildcard Snakefile workflow)
	$(RUN) snakemake --lint
	$(RUN) lint-imports

format: env
	$(RUN) ruff check --fix .
	$(RUN) ruff format .
	$(RUN) snakefmt $(wildcard Snakefile workflow)

# The site, in results/docs: open results/docs/index.html. Warnings are errors; tests/docs checks its links.
docs: env
	$(RUN) python -m sphinx -W --keep-going -q docs results/docs

docs-pictures: env
	$(RUN) PYTHONPATH=workflow python -m docs.draw_effects

readme-figures: env
	$(RUN) python paper/refresh_figures.py

# On a real Slurm cluster, of Debian's packages, on the loopback of this machine. Installs nothing; not part of `make test`.
test-slurm: env
	$(RUN) PYTHONPATH=.:workflow python -m tests.slurm

bench: env
	$(RUN) python -m benchmarks

# Needs the network the first time. A package that cannot be installed is said in the table, and the others go on.
bench-trackers: env
	$(RUN) PYTHONPATH=.:workflow python -m benchmarks.trackers.environments
	$(RUN) PYTHONPATH=.:workflow python -m benchmarks.trackers

# JAX in an environment of its own, which nothing else of the project knows.
SOLVERS := .venv-solvers/.locked
$(SOLVERS): benchmarks/solvers/requirements.txt $(LOCKED)
	rm -rf .venv-solvers; $(BIN)/python -m venv --without-pip .venv-solvers
	$(BIN)/uv pip install --quiet --compile-bytecode --python .venv-solvers/bin/python --require-hashes --no-deps -r $<
	@touch $@

bench-solvers: env $(SOLVERS)
	$(RUN) python -m benchmarks.other_solvers

# Not `env`: a lock that cannot be installed must not keep one from making a better one.
# --no-emit-index-url: the lock holds versions and hashes, and works with whatever index the reader's machine uses.
COMPILE = UV_CUSTOM_COMPILE_COMMAND="make lock" $(BIN)/uv pip compile --quiet --universal --python-version 3.11 \
	--generate-hashes --no-emit-index-url --no-emit-find-links
lock:
	$(COMPILE) $(LOCK_ARGS) pyproject.toml --all-extras -o requirements/lock.txt
	$(COMPILE) requirements/bootstrap.in -c requirements/lock.txt -o requirements/bootstrap.txt
	$(COMPILE) benchmarks/solvers/requirements.in -o benchmarks/solvers/requirements.txt
	$(BIN)/python workflow/envs/write_environment.py

# Not `env`: what is audited is the lock, whether or not it is installed.
audit:
	@PATH="$$PATH:$(CURDIR)/$(BIN)" $(find_python) .ci/audit.py

# picos, of figaroh, has no wheel, and calibration does without it.
TRACKERS := benchmarks/trackers/requirements
lock-trackers:
	for package in pybotics robotkinecal figaroh; do \
		$(subst "make lock","make lock-trackers",$(COMPILE)) $(LOCK_ARGS) --no-emit-package picos \
			$(TRACKERS)/$$package.in -o $(TRACKERS)/$$package.txt || exit 1; \
	done

release: env
	$(BIN)/python .ci/release.py $(VERSION)

clean:
	rm -rf .venv .venv-solvers .bench benchmarks/built .pytest_cache .ruff_cache .hypothesis .import_linter_cache .snakemake build dist
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
