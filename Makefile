# Every target makes its own environment first: Python 3.11 and make are all a machine needs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP_INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --no-deps

# The lock files name all dependencies, so that none has to be looked for. Modules are compiled when they are first imported:
# few of the ten thousand installed are. And bytecode is kept, whatever the environment says: otherwise each process of the
# service and its tests would compile its modules again.
export PYTHONDONTWRITEBYTECODE :=

# Not written out in recipes: a line with the variable of make itself would run under `make -n` as well.
SUBMAKE := $(MAKE) --no-print-directory

# Processes that run tests; one runs those of a file, or of one service. Many wait for services, so three keep two cores busy.
TESTERS ?= 3

.DEFAULT_GOAL := help
.PHONY: help demo serve test browser test-containers lint format gallery generate bench lock clean

help:  ## list the targets
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## (.*)/  make \1\t\2/' | expand -t 24

$(VENV)/runtime: requirements/runtime.txt client/pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("isomatch needs Python 3.11 or newer") if sys.version_info < (3, 11) else None'
	@echo "Making the environment in $(VENV): once, and some minutes where packages come slowly ..."
	@$(PYTHON) -m venv $(VENV)
	@$(PIP_INSTALL) --require-hashes -r requirements/runtime.txt
	@$(PIP_INSTALL) --no-build-isolation --editable client
	@touch $@

$(VENV)/dev: $(VENV)/runtime requirements/dev.txt
	@echo "Adding what the tests need ..."
	@$(PIP_INSTALL) --require-hashes -r requirements/dev.txt
	@touch $@

demo: $(VENV)/runtime  ## start everything, match two generated shapes, draw the answer
	$(BIN)/python -m demo

serve: $(VENV)/runtime  ## run the whole service on this machine until interrupted
	$(BIN)/python -m service

# The kernels are compiled before the tests: otherwise each of the tests' processes would do it at the same time. Beside it the
# packages for the tests are installed, and the checks begin; these go on beside the tests, and give way to them.
test: $(VENV)/runtime  ## the checks and all tests
	@ISOMATCH_LOG_LEVEL=WARNING $(BIN)/python -m worker --warm-up & warming=$$!; \
	$(SUBMAKE) $(VENV)/dev browser || { kill $$warming; exit 1; }; \
	nice $(SUBMAKE) lint & checking=$$!; \
	wait $$warming || { kill $$checking; exit 1; }; \
	$(BIN)/python -m pytest --numprocesses $(TESTERS) --dist loadfile --no-loadscope-reorder --durations 15; tested=$$?; \
	wait $$checking || { echo "The checks failed; what they found is said above the tests."; exit 1; }; \
	exit $$tested

# Playwright's own browsers come from a host of their own; Debian's serves as well.
APT := apt-get -o Acquire::Retries=1 -o Acquire::http::Timeout=30 -o DPkg::Lock::Timeout=120 -qq
browser:  ## a Chromium to test the page in: Debian's, if this is Debian and you are root
	@command -v chromium-headless-shell || command -v chromium || command -v chromium-browser || command -v google-chrome || { \
	test "$$(id -u)" = 0 && command -v apt-get >/dev/null && { timeout 300 $(APT) update; \
	DEBIAN_FRONTEND=noninteractive timeout 300 $(APT) install -y --no-install-recommends chromium-headless-shell >/dev/null; }; } || \
	echo "No Chromium can be installed here; tests of the page in a browser will be skipped."

test-containers: $(VENV)/dev  ## build the images and run them, with an engine of its own (Debian, as root, ten minutes)
	$(BIN)/python -m pytest -v -p no:cacheprovider --timeout 1800 tests/containers/checks.py

lint: $(VENV)/dev  ## style, types, the direction of imports, and what is in docker/
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/hadolint docker/Dockerfile
	$(BIN)/check-jsonschema --quiet --builtin-schema vendor.compose-spec docker/compose*.yaml
	$(BIN)/kubernetes-validate --strict --quiet docker/kubernetes/[!k]*.yaml

format: $(VENV)/dev  ## put the code in house style
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(VENV)/runtime  ## measure: correspondences, pairs, bounds, invariance (ISOMATCH_DATA: a folder of meshes)
	$(BIN)/python -m bench.correspondence
	$(BIN)/python -m bench.pair
	$(BIN)/python -m bench.solver
	$(BIN)/python -m bench.certificates
	$(BIN)/python -m bench.minimax --points 8 12 16
	$(BIN)/python -m bench.spectrum --most 10000
	$(BIN)/python -m bench.geodesics --most 5000
	$(BIN)/python -m bench.refinement --every 4
	$(BIN)/python -m bench.invariance
	$(BIN)/python -m bench.service

gallery: $(VENV)/runtime  ## draw the pictures of docs/gallery.md: run it against a service of its own
	$(BIN)/python -m demo.gallery

generate: $(VENV)/dev  ## write what follows from the declarations: contracts, OpenAPI, client, page, documents
	$(BIN)/python -m codegen

# The lock files hold versions and hashes, and no address of where they came from.
LOCK := $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
	--no-annotate --no-header --no-emit-index-url --no-emit-find-links
lock: $(VENV)/dev  ## renew requirements/*.txt from the pyproject files
	$(LOCK) $(UPGRADE) pyproject.toml client/pyproject.toml requirements/build.in --extra demo \
		-o requirements/runtime.txt
	$(LOCK) $(UPGRADE) pyproject.toml client/pyproject.toml requirements/build.in --extra demo --extra dev \
		-c requirements/runtime.txt -o requirements/dev.txt
	$(LOCK) $(UPGRADE) requirements/service.in -c requirements/runtime.txt -o requirements/service.txt
	$(LOCK) $(UPGRADE) requirements/worker.in -c requirements/runtime.txt -o requirements/worker.txt

clean:  ## remove what the targets above made
	rm -rf $(VENV) demo-output bench-output isomatch-data
