# MechStyle's chores. `make` alone lists them.
# Needs python3 (3.11 or newer) with its venv module; everything else goes into .venv.

PYTHON ?= python3
BIN := .venv/bin
NOTEBOOKS ?= cache
PINS := pyproject.toml constraints.txt
TESTS := $(BIN)/python -m pytest -n 2 --durations=40
QUICK := -m 'not slow and not browser' --ignore=tests/browser --ignore=tests/cli --ignore=tests/notebooks --ignore=tests/validation
# Two test workers share the cores; a thread pool in each would only make them wait for each other.
export OMP_NUM_THREADS ?= 1
# Where it is set, every process compiles all it imports again: 7 CPU seconds in place of 2, and tests start hundreds.
unexport PYTHONDONTWRITEBYTECODE
export PIP_DISABLE_PIP_VERSION_CHECK = 1

.PHONY: help demo quick test test-trust fuzz lab docs pictures lint mutants bench bench-widgets clean
.DEFAULT_GOAL := help
.NOTPARALLEL:

help: ## list these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-13s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

demo: .venv/core.stamp ## style a trophy freely and with feedback, drop both, write demo-out/
	$(BIN)/mechstyle demo --out demo-out

quick: .venv/dev.stamp ## tests without browser, notebooks, command line, published figures and what is slow: while you work
	$(BIN)/ruff check --quiet .
	$(BIN)/lint-imports --no-cache
	$(TESTS) $(QUICK)

# mypy takes one core for a minute, and is done long before the tests are: both run, and both must pass.
test: .venv/dev.stamp ## everything that must pass: lint, types, import directions, all tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check --quiet .
	$(BIN)/lint-imports --no-cache
	@$(BIN)/mypy & types=$$!; $(TESTS); tests=$$?; wait $$types && exit $$tests

test-trust: .venv/dev.stamp ## kill 155 runs at seeded moments and compare what they come to, carried on
	$(BIN)/python benchmarks/trust.py

fuzz: .venv/dev.stamp ## read 10 000 damaged and hostile files and command lines
	$(BIN)/python benchmarks/fuzz.py

lab: .venv/lab.stamp ## open the Studio and the lessons in JupyterLab; installs what a lesson needs and no more
	$(BIN)/jupyter lab --notebook-dir=. notebooks/00_studio.ipynb

docs: .venv/docs.stamp ## build/site/index.html, with all notebooks executed; NOTEBOOKS=off shows them as they are stored
	$(BIN)/python docs/site/prose.py
	rm -rf build/site  # Sphinx keeps pages whose own text is as it was; notebooks have a cache
	MECHSTYLE_DOCS_EXECUTE=$(NOTEBOOKS) $(BIN)/sphinx-build --quiet --fail-on-warning --keep-going -b html -c docs . build/site
	$(BIN)/python docs/site/check.py build/site

pictures: .venv/dev.stamp ## every picture of README and pages that shows a simulation, again (ten minutes of two cores)
	$(BIN)/python benchmarks/pictures.py

lint: .venv/dev.stamp ## style, import directions and types only
	$(BIN)/ruff check .
	$(BIN)/ruff format --check --quiet .
	$(BIN)/lint-imports --no-cache
	$(BIN)/mypy

mutants: .venv/dev.stamp ## seeded mutation run over the pure modules
	$(BIN)/python benchmarks/mutants.py

bench: .venv/dev.stamp ## speed and memory of stages, drops and renderer beside their budgets
	$(BIN)/python benchmarks/stages.py
	$(BIN)/python benchmarks/drops.py
	$(BIN)/python benchmarks/renderer.py

bench-widgets: .venv/dev.stamp ## size and speed of report, replay, viewer and Studio in headless Chromium
	$(BIN)/python benchmarks/widgets.py $(RUN)
	$(BIN)/python benchmarks/lab.py

clean: ## remove .venv, caches and demo-out/ (your runs stay)
	rm -rf .venv .mypy_cache .ruff_cache .pytest_cache .hypothesis build *.egg-info demo-out
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/bin/python:
	@command -v $(PYTHON) >/dev/null || { echo "There is no $(PYTHON): install Python 3.11 or newer (Debian: apt-get install python3 python3-venv)."; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "$(PYTHON) is too old: MechStyle needs Python 3.11 or newer (say which with make PYTHON=python3.11)."; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "Python's venv module is missing: install it (Debian: apt-get install python3-venv) and run make again."; exit 1; }
	$(PYTHON) -m venv .venv

# A larger install contains the smaller ones, so it renews their stamps; a renewed smaller one leaves the larger to renew itself when asked for.
.venv/core.stamp: $(PINS) | .venv/bin/python
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable .
	@touch $@

.venv/lab.stamp: $(PINS) | .venv/bin/python
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[jupyter]'
	@touch .venv/core.stamp $@

.venv/dev.stamp: $(PINS) | .venv/bin/python
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[dev,jupyter,clip]'
	@touch .venv/core.stamp .venv/lab.stamp $@

.venv/docs.stamp: .venv/dev.stamp
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[dev,jupyter,clip,docs]'
	@touch $@
