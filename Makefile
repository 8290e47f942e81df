# `make demo` and `make test` set up everything they need in .venv, from the versions that
# constraints.txt names. `make PYTHON=python3.12 ...` chooses the interpreter, VENV another folder.

SHELL := /bin/bash
.DEFAULT_GOAL := help
.PHONY: help install check-python test test-all test-jazzy jazzy-python test-processors lint demo gui loop survey docs evaluation bench table fuzz soak clean

CANDIDATES := python3 python3.12 python3.11 python3.13 python3.14
PYTHON ?= $(shell for p in $(CANDIDATES); do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 15))' 2>/dev/null \
	&& { echo $$p; break; }; done)
VENV := .venv
BIN := $(VENV)/bin
SOURCE ?=
DEMO := demo
SEED ?= 1
SEEDS ?= 10
FOOTAGE ?=
BLOCK ?=
TABLE := cable_tracker/cable/measure/borders/response_table.json
TABLE_SCENARIOS := S1 S2 S3 S4 S5 S6 night tune_*
TABLE_FIRST_SEED := 200
TABLE_SEEDS := 6
TABLE_FRAMES := 100
TABLE_EVERY := 4
RUNS ?= 100000
FUZZ_SEED ?= 1
FUZZ_TARGETS ?= picture raw_image sequence_file mcap sqlite ros1 video video_stream metadata parameters target
FUZZ := fuzz
MINUTES ?= 10
TIER ?=
# Tests beside linters: those for every change, and what is left for before a merge.
PYTEST := python -m pytest -n 2 --dist worksteal --timeout 600 --instafail -q
QUICK := -m "not slow and not browser" --hypothesis-profile quick
TESTS ?= test
# The versions of Ubuntu 24.04, which ROS 2 Jazzy is made for; its Python is 3.12.
JAZZY_VENV := .venv-jazzy
JAZZY_PYTHON ?= $(shell for p in python3.12 $(HOME)/.pyenv/versions/3.12*/bin/python; do \
	$$p -c 'import sys; sys.exit(sys.version_info[:2] != (3, 12))' 2>/dev/null \
	&& { echo $$p; break; }; done)
JAZZY_TIER ?= $(QUICK)
# A home that cannot be written to must not stop ROS from logging.
export ROS_LOG_DIR ?= $(CURDIR)/$(VENV)/log/ros
export MPLCONFIGDIR ?= $(CURDIR)/$(VENV)/cache/matplotlib
# The tests start the same modules in many processes: what was parsed once is kept.
export PYTHONDONTWRITEBYTECODE :=

help:
	@echo "make demo                  simulate dives, an easy and a hard one, track them, show the errors"
	@echo "make demo SOURCE=path      the same for a recording of yours"
	@echo "make gui                   watch and tune the filter in a browser, on a simulated dive"
	@echo "make gui SOURCE=path       the same on a recording of yours"
	@echo "make loop                  let a simulated vehicle follow 100 m of cable, over DDS"
	@echo "make survey                map a cable from simulated dives, with a report"
	@echo "make test                  linters, type checks, and the tests for every change"
	@echo "make test-all              the whole suite, with long tests and those of the pages"
	@echo "make test-jazzy            the tests with the versions of Ubuntu 24.04, on Python 3.12"
	@echo "make test-processors       the whole suite as other processors and a busy one would run it"
	@echo "make install               set up $(VENV); the others do it by themselves"
	@echo "make docs                  write config/*.yaml, docs/parameters.md and docs/api.md from the code"
	@echo "make evaluation            evaluate all methods, and write the tables of docs/evaluation.md"
	@echo "make bench                 measure speeds, and write them into docs/performance.md"
	@echo "make table                 learn the tables of the likelihood ratio, in some minutes"
	@echo "make fuzz RUNS=1000000     feed damaged files to all that reads files, so many to each"
	@echo "make soak MINUTES=60       feed a tracker process for a long time and inject faults"
	@echo "make clean                 remove $(VENV) and what the demo wrote"

check-python:
	@if [ -z "$(PYTHON)" ]; then \
		echo "error: Python 3.11 to 3.14 is needed and none of $(CANDIDATES) is one;" \
			"install it (Debian, Ubuntu: apt install python3 python3-venv)" \
			"or name it: make PYTHON=/path/to/python ..." >&2; exit 2; fi
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 15))' || { \
		echo "error: $(PYTHON) is not Python 3.11 to 3.14; name one with make PYTHON=..." >&2; \
		exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
		v=$$($(PYTHON) -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])'); \
		echo "error: $(PYTHON) has no venv; install it (Debian, Ubuntu: apt install $$v)" >&2; \
		exit 2; }

install: $(VENV)/installed

$(VENV)/installed: setup.py setup.cfg constraints.txt package.xml | check-python
	@echo "setting up $(VENV) with $(PYTHON), which takes some minutes ..."
	@$(PYTHON) -m venv --clear $(VENV)
	@mkdir -p $(ROS_LOG_DIR) $(MPLCONFIGDIR)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt \
		--upgrade pip setuptools wheel
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt \
		--no-build-isolation -e ".[ros,gui,dev]"
	@echo "compiling the inner loops, once ..."
	@$(BIN)/cable-tracker warm-up
	@touch $@

test: install lint
	$(BIN)/$(PYTEST) $(QUICK) $(TESTS)

test-all: install lint
	$(BIN)/$(PYTEST) --durations 20 $(TESTS)

# Whole, it takes as long as five times the suite. `TESTS=test/cable` chooses a part of it, and
# `TIER=quick` the tests for every change; `python test/processors.py --help` tells more.
test-processors: install
	$(BIN)/python test/processors.py $(if $(filter quick,$(TIER)),$(QUICK)) -n 2 --timeout 3600 -q $(TESTS)

# JAZZY_TIER= (empty) runs all tests. Warnings of deprecated names come from what the platform has.
test-jazzy: $(JAZZY_VENV)/installed
	$(JAZZY_VENV)/bin/$(PYTEST) -W default::DeprecationWarning $(JAZZY_TIER) $(TESTS)

jazzy-python:
	@echo $(JAZZY_PYTHON)

$(JAZZY_VENV)/installed: setup.py setup.cfg constraints.txt constraints-jazzy.txt package.xml
	@test -n "$(JAZZY_PYTHON)" || { \
		echo "error: Python 3.12 is needed; name it with make JAZZY_PYTHON=..." >&2; exit 2; }
	@echo "setting up $(JAZZY_VENV) with $(JAZZY_PYTHON), which takes some minutes ..."
	@$(JAZZY_PYTHON) -m venv --clear $(JAZZY_VENV)
	@mkdir -p $(ROS_LOG_DIR) $(MPLCONFIGDIR)
	@grep -v -i -F -f <(sed -n 's/==.*/==/p' constraints-jazzy.txt) constraints.txt \
		> $(JAZZY_VENV)/constraints.txt
	@cat constraints-jazzy.txt >> $(JAZZY_VENV)/constraints.txt
	@$(JAZZY_VENV)/bin/python -m pip install --quiet --disable-pip-version-check \
		-c $(JAZZY_VENV)/constraints.txt setuptools wheel
	@$(JAZZY_VENV)/bin/python -m pip install --quiet --disable-pip-version-check \
		-c $(JAZZY_VENV)/constraints.txt --no-build-isolation -e ".[ros,test]"
	@$(JAZZY_VENV)/bin/cable-tracker warm-up
	@touch $@

lint: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

demo: install
	@mkdir -p $(DEMO)
ifeq ($(strip $(SOURCE)),)
	@echo "simulating a dive over a cable ..."
	@$(BIN)/cable-tracker simulate $(DEMO)/dive --frames 300 --seed 1 --force
	@echo "replaying it to the tracker over DDS, in lockstep ..."
	@$(BIN)/cable-tracker track $(DEMO)/dive --ros --init truth --output $(DEMO)/dive_tracked --force
	@echo
	@echo "now a hard one: an old cable, overgrown, half buried among stones, and quick moves ..."
	@$(BIN)/cable-tracker simulate $(DEMO)/hard_dive --scenario S4 --seed 1 --force
	@$(BIN)/cable-tracker track $(DEMO)/hard_dive --init truth --no-bag \
		--output $(DEMO)/hard_dive_tracked --force
	@echo "beside it, Hough lines on the same frames ..."
	@$(BIN)/cable-tracker evaluate --source $(DEMO)/hard_dive --method default --method hough \
		--seeds 1 --workers 1 --output $(DEMO)/hard_dive_judged --force
	@echo "look at $(DEMO)/dive_tracked/overlay.png and $(DEMO)/hard_dive_tracked/overlay.png"
	@echo "(green: estimate, its band: two sigma of the centreline; pink dashes: truth; blue: particles)"
else
	@echo "replaying $(SOURCE) to the tracker over DDS, in lockstep ..."
	@$(BIN)/cable-tracker track "$(SOURCE)" --ros --output $(DEMO)/your_recording_tracked --force
endif

gui: install
ifeq ($(strip $(SOURCE)),)
	@test -d $(DEMO)/dive || { mkdir -p $(DEMO) && echo "simulating a dive over a cable ..." && \
		$(BIN)/cable-tracker simulate $(DEMO)/dive --frames 300 --seed 1; }
	@$(BIN)/cable-tracker gui $(DEMO)/dive --init truth
else
	@$(BIN)/cable-tracker gui "$(SOURCE)"
endif

loop: SEED = 2
loop: install
	@mkdir -p $(DEMO)
	@echo "a simulated vehicle follows 100 m of cable, which takes some minutes ..."
	@$(BIN)/cable-tracker loop --seed $(SEED) --output $(DEMO)/loop --force

# Two dives over one cable, of few frames a second: the cable moves by 10 cm from one to the next.
survey: install
	@mkdir -p $(DEMO)/survey
	@echo "two vehicles inspect 50 m of cable ..."
	@for seed in 1 2; do \
		$(BIN)/cable-tracker simulate $(DEMO)/survey/dive_$$seed --survey 50 --rate 5 \
			--seed $$seed --force & done; wait
	@$(BIN)/cable-tracker survey $(DEMO)/survey/dive_1 $(DEMO)/survey/dive_2 \
		--output $(DEMO)/survey/map --workers 2 --force

docs: install
	$(BIN)/python docs/generate.py

evaluation: install
	$(BIN)/python docs/evaluation_tables.py --seeds $(SEEDS) $(FOOTAGE:%=--footage %) \
		$(BLOCK:%=--block %)

bench: install
	$(BIN)/cable-tracker dev bench --dds --force --markdown docs/performance.md

# The tables that ship with the package. The evaluation's dives have the seeds 0, 1, ...
table: install
	$(BIN)/cable-tracker learn $(TABLE_SCENARIOS:%=--scenario '%') \
		--first-seed $(TABLE_FIRST_SEED) --seeds $(TABLE_SEEDS) --frames $(TABLE_FRAMES) \
		--every $(TABLE_EVERY) --seed 0 --output $(TABLE) --force

# What is found lies in $(FUZZ)/findings; mended, it belongs in test/fuzz/examples/TARGET.
fuzz: install
	@mkdir -p $(FUZZ)
	@for target in $(FUZZ_TARGETS); do \
		echo "fuzzing $$target ..."; \
		$(BIN)/python test/fuzz/run.py $$target --runs $(RUNS) --seed $(FUZZ_SEED) \
			--corpus $(FUZZ)/corpus/$$target --findings $(FUZZ)/findings \
			2> $(FUZZ)/$$target.log || { tail -n 40 $(FUZZ)/$$target.log; exit 1; }; \
		grep -e executed_units -e slowest -e peak_rss $(FUZZ)/$$target.log; done

soak: install
	$(BIN)/cable-tracker dev soak --minutes $(MINUTES) --seed $(SEED) --force

clean:
	rm -rf $(VENV) $(JAZZY_VENV) $(DEMO) $(FUZZ) soak.json build install log *.egg-info .mypy_cache .ruff_cache .pytest_cache \
		.hypothesis
