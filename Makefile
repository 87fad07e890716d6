# Every target works in a fresh clone: it makes .venv, installs what it needs there and builds.
# Variables: PYTHON (an interpreter, 3.11 to 3.13), VENV (default .venv), RB_PHYSICS_JOBS.

VENV ?= .venv
PY := $(VENV)/bin/python
SOURCES := rb_physics nodes launch tests benchmarks setup.py
CPP := $(shell find rb_physics/core -name '*.cpp' -o -name '*.hpp' | sort)

# ccache makes rebuilding after `make clean` or a branch switch cheap; nothing depends on it.
ifneq ($(shell command -v ccache 2>/dev/null),)
ifeq ($(origin CC),default)
export CC := ccache gcc
export CXX := ccache g++
export CCACHE_NOHASHDIR := 1
endif
endif

.PHONY: help build demo test soak lint format sanitize bench bench-engines bench-node gallery pictures verify clean
help:
	@echo "make demo      the node, a second process that pushes bodies, and a recording of it (10 s)"
	@echo "make test      every test but the long ones"
	@echo "make soak      the long ones: full counts, installs with pip and colcon"
	@echo "make lint      ruff, mypy, clang-format, and a build with warnings as errors"
	@echo "make sanitize  the core's tests under AddressSanitizer and UBSan"
	@echo "make verify    accuracy against exact answers, as a table"
	@echo "make bench     speed of the broad and the narrow phase and of recording; instructions per step"
	@echo "make bench-engines  speed and penetration beside other engines (10 min on a quiet machine)"
	@echo "make gallery   docs/images/shapes.png, rendered from a recording"
	@echo "make pictures  every layout of the Rerun view, of three scenes (build/pictures)"
	@echo "make bench-node  the node at 1 kHz with 100 bodies beside a plain rclpy node, and with 1000 (4 min, quiet machine)"
	@echo "make format    rewrite sources in the project's format"
	@echo "make clean     remove what was built (keeps $(VENV) and recordings/)"

$(PY):
	@set -e; for python in $${PYTHON:-python3 python3.13 python3.12 python3.11}; do \
	  if "$$python" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' \
	    2>/dev/null; then found="$$python"; break; fi; done; \
	if [ -z "$${found:-}" ]; then \
	  echo "rb_physics needs Python 3.11, 3.12 or 3.13 (looked for $${PYTHON:-python3, python3.13, python3.12, python3.11}); install one or set PYTHON=/path/to/python3." >&2; exit 1; fi; \
	if ! "$$found" -m venv $(VENV); then \
	  rm -rf $(VENV); \
	  echo "$$found cannot make a virtual environment; on Debian and Ubuntu: apt install python3-venv." >&2; exit 1; fi

# One stamp per set of extras; "base" has none.
$(VENV)/installed-%: setup.cfg setup.py pyproject.toml | $(PY)
	$(PY) -m pip install -q "setuptools>=68,<80" wheel "pybind11>=2.13" "cmeel-eigen>=3.4,<4"
	$(PY) -m pip install -q --no-build-isolation -e '.$(if $(filter base,$*),,[$*])'
	@touch $@

build: $(VENV)/installed-base
	@$(PY) setup.py -q build_ext --inplace

demo: build
	$(PY) -m rb_physics_nodes.demo

test: $(VENV)/installed-test build
	$(PY) -m pytest

soak: $(VENV)/installed-test $(VENV)/installed-dev build
	$(PY) -m pytest -m soak --timeout 3600

lint: $(VENV)/installed-dev build
	$(PY) -m ruff check $(wildcard $(SOURCES))
	$(PY) -m ruff format --check $(wildcard $(SOURCES))
	$(PY) -m mypy
	@$(VENV)/bin/clang-format --dry-run -Werror $(CPP)
	RB_PHYSICS_WERROR=1 $(PY) setup.py -q build_ext --build-lib build/werror

format: $(VENV)/installed-dev
	$(PY) -m ruff check --fix-only $(wildcard $(SOURCES))
	$(PY) -m ruff format $(wildcard $(SOURCES))
	$(VENV)/bin/clang-format -i $(CPP)

# Python itself is not instrumented, so the sanitizers are preloaded (libstdc++ with them: ASan must
# find __cxa_throw at start) and leaks, most of them the interpreter's own, are not reported.
sanitize: $(VENV)/installed-test build
	RB_PHYSICS_SANITIZE=1 $(PY) setup.py -q build --build-base build/sanitize --build-lib build/sanitize/lib
	@mkdir -p build/sanitize/share/rb_physics
	@ln -sfn $(CURDIR)/scenes $(CURDIR)/msg_configs build/sanitize/share/rb_physics/
	env LD_PRELOAD="$$(gcc -print-file-name=libasan.so) $$(gcc -print-file-name=libstdc++.so)" \
	  ASAN_OPTIONS=detect_leaks=0:abort_on_error=1 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 \
	  PYTHONPATH=build/sanitize/lib RB_PHYSICS_TEST_BUILD=build/sanitize/lib \
	  $(VENV)/bin/pytest -p no:cacheprovider --ignore=tests/nodes --ignore=tests/recording

bench: $(VENV)/installed-bench build
	$(PY) -m benchmarks.broad_phase
	$(PY) -m benchmarks.geometry
	$(PY) -m benchmarks.recording
	$(PY) -m benchmarks.instructions

bench-engines: $(VENV)/installed-bench-engines build
	$(PY) -m benchmarks.engines

bench-node: $(VENV)/installed-bench build
	$(PY) -m benchmarks.node_loop
	$(PY) -m benchmarks.node_loop --bodies 1000 --hz 250 --no-body-topics --no-plain

# The picture of every shape in the README, from a recording of scenes/shapes.yaml.
gallery: $(VENV)/installed-test build
	rm -rf build/gallery && mkdir -p build/gallery
	$(VENV)/bin/rb_physics run scenes/shapes.yaml --duration 1 --record build/gallery/run
	$(VENV)/bin/rb_physics view build/gallery/run --layout contact --png build/gallery/view.png
	$(PY) -c "from PIL import Image; Image.open('build/gallery/view.png').convert('RGB').crop((510, 200, 1130, 510)).save('docs/images/shapes.png', optimize=True)"

pictures: $(VENV)/installed-test build
	$(PY) -m benchmarks.pictures --docs

verify: $(VENV)/installed-test build
	$(PY) -m benchmarks.accuracy

clean:
	rm -rf build dist *.egg-info rb_physics/*.so .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -not -path './$(VENV)/*' -prune -exec rm -rf {} +
