# Each target does its own set-up on a fresh Debian or Ubuntu machine. Stamps in .venv make repeated calls instant.

SHELL := /bin/bash
VENV := .venv
BIN := $(VENV)/bin
OUT := out

.PHONY: help demo test check gallery bench fuzz format ready-test clean
.DELETE_ON_ERROR:

help:
	@echo "make demo     render a real head to demo.png"
	@echo "make test     run the tests"
	@echo "make check    lint, formatting, types, order of imports"
	@echo "make gallery  render the pictures of the gallery"
	@echo "make bench    time a fixed set of scenes, beside VTK where it can be installed"
	@echo "make fuzz     feed the readers thousands of damaged files (slow)"

demo: $(VENV)/.adapter
	@$(BIN)/airlight demo -o demo.png

test: ready-test
	@scripts/test.sh

ready-test: $(VENV)/.test $(VENV)/.adapter $(VENV)/.browser

check: $(VENV)/.check
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(VENV)/.check
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

gallery: $(VENV)/.test $(VENV)/.adapter
	$(BIN)/python scripts/gallery.py

bench: $(VENV)/.bench $(VENV)/.adapter
	@mkdir -p $(OUT)
	$(BIN)/airlight bench -o $(OUT)/bench.json
	$(BIN)/python benchmarks/throughput.py
	$(BIN)/python benchmarks/cold_start.py
	$(BIN)/python benchmarks/against_vtk.py

fuzz: ready-test
	$(BIN)/python -m pytest -n 2 -m fuzz

$(BIN)/python:
	@scripts/setup.sh venv

$(VENV)/.package: pyproject.toml | $(BIN)/python
	@scripts/setup.sh install .
	@touch $@

$(VENV)/.test: pyproject.toml $(VENV)/.package
	@scripts/setup.sh install '.[all]' test
	@touch $@

$(VENV)/.check: pyproject.toml $(VENV)/.package
	@scripts/setup.sh install '.[all]' check
	@touch $@

$(VENV)/.bench: pyproject.toml $(VENV)/.package
	@scripts/setup.sh install . bench || echo "VTK cannot be installed here; timing airlight alone"
	@touch $@

$(VENV)/.adapter: | $(VENV)/.package
	@scripts/setup.sh adapter
	@touch $@

$(VENV)/.browser: | $(VENV)/.package
	@scripts/setup.sh browser
	@touch $@

clean:
	rm -rf $(VENV) $(OUT) build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
