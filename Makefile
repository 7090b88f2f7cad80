# Two commands do all set-up, on a machine with only Python and make:
#   make test        check the code; `make test-thorough` with the slow cases, too
#   make reproduce   the paper's study, small; `make reproduce SCALE=paper` the whole of it.
#                    It ends with the path of a report. Stopped, it goes on where it was.
#                    Body and reading are the study's own of docs/reproduction/fidelity.md, as in most tables
#                    of the docs; with READING=calibrated those of docs/reproduction/calibration.md,
#                    whose leg is damped in flight, where the paper switches the damper off.
#                    READING=reading.toml takes your own numbers, at the paper's scale unless SCALE says otherwise.

PYTHON ?= python3
VENV ?= .venv
READING ?= study
FILE := $(filter %.toml %.json,$(READING))
SCALE ?= $(if $(FILE),paper,quick)
$(if $(FILE)$(filter $(READING),study calibrated),,$(error READING is $(READING); it must be study, calibrated or a file, FILE.toml))
$(if $(FILE),$(if $(wildcard $(FILE)),,$(error READING is $(FILE); there is no such file)))
# Of each reading: its folder of records, and its tables.
STUDY_study := results/$(SCALE)
STUDY_calibrated := results/$(SCALE)-calibrated
STUDY := $(if $(FILE),results/$(SCALE)-$(basename $(notdir $(FILE))),$(STUDY_$(READING)))
TABLES_study := research/reproduction/kept/study/paper
TABLES_calibrated := research/reproduction/kept/study-calibrated/calibrated
TABLES := $(if $(FILE),$(STUDY)/tables/runs,$(TABLES_$(READING)))
# Experiments on single claims, which take longer than the study: a small scale shows those kept.
# To keep new ones: make experiments EXPERIMENTS=research/experiments
# Those of the calibrated body are its gain map.
EXPERIMENTS_study := $(if $(filter paper,$(SCALE)),results/experiments,research/experiments)
EXPERIMENTS_calibrated := $(dir $(TABLES_calibrated))
# The report of your own numbers names those that it lacks.
EXPERIMENTS := $(EXPERIMENTS_$(READING))
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed

PYTEST := $(BIN)/python -m pytest -n 2 --dist loadfile

.PHONY: test test-thorough solutions lint pytest reproduce study-tables experiments docs paper-figure bench clean

$(INSTALLED): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --no-compile --constraint constraints.txt --editable '.[all]'
	touch $@

test: $(INSTALLED)
	$(MAKE) --jobs 2 lint pytest

# Programs of tests run once or twice: XLA and LLVM compile them without their best, in a quarter of
# the time; LLVM's results are the same bits.
# Tests that turn on rounding, and `make test-thorough`, compile as users do.
QUICKLY := --xla_backend_optimization_level=0 --xla_cpu_use_fusion_emitters=false
PRECISE = $(shell grep --recursive --files-with-matches --include='test_*.py' mark.precise tests)
# Programs that tests start read the bytecode of modules, and do not compile each of them anew.
unexport PYTHONDONTWRITEBYTECODE
pytest: $(INSTALLED)
	LANEWISE_OPT=0 XLA_FLAGS="$(QUICKLY)" $(PYTEST) -m "not thorough and not precise"
	$(PYTEST) -n 0 -m "precise and not thorough" $(PRECISE)

test-thorough: lint
	TEGOTAE_SOLVE=compare $(PYTEST) -m "thorough or not thorough"

# What adaptive solvers say, which tests compare with: anew after a change of theirs.
solutions: $(INSTALLED)
	TEGOTAE_SOLVE=keep $(BIN)/python -m pytest -q -m "thorough or not thorough" tests/simulation/test_accuracy.py \
	  tests/measures/test_evaluation.py

lint: $(INSTALLED)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright --pythonpath $(BIN)/python

reproduce: $(INSTALLED)
	$(BIN)/python -m research.reproduction run --dir $(STUDY) --scale $(SCALE) --reading $(READING)
ifeq ($(READING) $(SCALE),study paper)
	$(MAKE) experiments EXPERIMENTS=$(EXPERIMENTS)
endif
	$(BIN)/python -m research.reproduction report --dir $(STUDY) $(if $(FILE),,--experiments $(EXPERIMENTS))

# The tables and figures of a reading's page, from its study's folder.
PAGE := $(patsubst %/,%,$(dir $(TABLES)))
BESIDE_study := research/reproduction/kept/study/paper-deviation-0.2.csv research/reproduction/kept/study/paper-80x16.csv \
  $(TABLES_calibrated).csv
BESIDE_calibrated := $(TABLES_study).csv
# After which training a verdict turns is asked of the study's own reading alone.
BUDGETS_study := --budgets $(TABLES_study)-budgets.csv
BUDGETS := $(BUDGETS_$(READING))
study-tables: $(INSTALLED)
	$(BIN)/python -m research.reproduction export --dir $(STUDY) --out $(TABLES).csv $(BUDGETS) \
	  --sampled $(TABLES)-sampled.csv
	$(BIN)/python -m research.reproduction figures $(STUDY) --out $(PAGE)
	$(BIN)/python -m research.reproduction claims $(TABLES).csv --out $(PAGE) $(BUDGETS) \
	  --sampled $(TABLES)-sampled.csv --beside $(BESIDE_$(READING)) \
	  --calibrated $(TABLES_calibrated).csv \
	  --experiments $(if $(filter study,$(READING)),research/experiments,$(PAGE)) \
	  --readings research/reproduction/kept/multiverse

experiments: EXPERIMENTS := results/experiments
experiments: $(INSTALLED)
	mkdir -p $(EXPERIMENTS)
	$(BIN)/python -m research.experiments.figure3 --tables $(EXPERIMENTS)
	$(BIN)/python -m research.experiments.second_look --first $(EXPERIMENTS)/figure3.csv \
	  --figure $(EXPERIMENTS)/second_look.png
	$(BIN)/python -m research.experiments.parameter_limit --out $(EXPERIMENTS)
	$(BIN)/python -m research.reproduction gain-map --out $(EXPERIMENTS)/gain_map.png

docs: $(INSTALLED)
	$(BIN)/sphinx-build -W --keep-going -b html docs docs/_build/html

paper-figure: $(INSTALLED)
	$(BIN)/tegotae figure portrait paper-sector --omega 5 --duration-s 20 --out research/paper/portrait.png

bench: $(INSTALLED)
	$(BIN)/python -m research.benchmarks

clean:
	rm -rf $(VENV) docs/_build
