# make plan   plan the paper's manipulator scenario
# make test   run every check: ruff, clang-format, pyright, pytest, notebooks, the page in a browser; WORKERS=8 for more processes
# make coverage   run the tests and report the lines of planner/ that they reach in this process, file by file
# make sanitize   run the tests of the compiled library once more, under the address and undefined-behaviour sanitizers
# make build   compile the C++ into the source tree; for a copy of the tree that borrows another's .venv, by PYTHONPATH
# make docs   build the documentation into docs/_build/html, with warnings as errors, and check its links
# make release   build the sdist into dist, install it on every Python from 3.11 to 3.13 that is here, and plan
# make pythons   the same with wheels of this tree, and without the Python of .venv
# make doors   run the tests of the ROS 2 node on Python 3.11, the only one with wheels of rclpy, in build/doors
# All set .venv up from the lock file if that has not been done.

PYTHON ?= $(shell for p in python3.13 python3.12 python3.11 python3 python; do \
	"$$p" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null && { echo "$$p"; break; }; done)
BIN := .venv/bin
DOORS := build/doors/bin/python
WORKERS ?= 3
NATIVE := $(wildcard planner/native/source/*.?pp planner/native/source/python/*.?pp)
BUILD := pyproject.toml CMakeLists.txt tools/build_backend.py

.PHONY: plan test coverage sanitize build docs release pythons doors lock clean
plan: .venv/ready
	$(BIN)/planner plan

test: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/clang-format --dry-run --Werror $(NATIVE)
	$(BIN)/pyright
	$(BIN)/pytest -n $(WORKERS) --dist worksteal

coverage: .venv/ready
	$(BIN)/pytest -n $(WORKERS) --dist worksteal --cov --cov-report=term:skip-covered

sanitize: .venv/ready
	$(BIN)/python -m tests.native.sanitized

build:
	$(BIN)/cmake -G Ninja -S . -B build/in_tree -DIN_TREE=ON -DCMAKE_BUILD_TYPE=Release \
		-DCMAKE_MAKE_PROGRAM=$(abspath $(BIN)/ninja) -DPython_EXECUTABLE=$(abspath $(BIN)/python)
	$(BIN)/cmake --build build/in_tree

docs: .venv/ready
	$(BIN)/python -m sphinx -q -E -W --keep-going -b html docs docs/_build/html
	$(BIN)/python docs/check_site.py docs/_build/html

# Pythons are looked for by name and among those of pyenv; each gets an environment of its own, all at once. ninja would
# take the job server of make -j from MAKEFLAGS, which a recipe cannot reach
release pythons: .venv/ready
	rm -rf dist
	$(BIN)/python -c "from scikit_build_core.build import build_sdist; build_sdist('dist')"
	@this=$$($(BIN)/python -c 'import sys; print("%d.%d" % sys.version_info[:2])'); \
	for version in 3.11 3.12 3.13; do \
		test "$@ $$version" != "pythons $$this" || continue; \
		python=$$(for p in python$$version "$${PYENV_ROOT:-$$HOME/.pyenv}"/versions/$$version.*/bin/python; do \
			"$$p" -c '' 2>/dev/null && { echo "$$p"; break; }; done); \
		test -n "$$python" || { echo "no Python $$version here: not tried"; continue; }; \
		( unset MAKEFLAGS MFLAGS; "$$python" -m venv --clear dist/venv-$$version \
			&& dist/venv-$$version/bin/pip install --quiet --no-compile --disable-pip-version-check $(INSTALLED) \
			&& dist/venv-$$version/bin/planner plan --nodes 60 --refinement-rounds 0 --out dist/out-$$version >dist/log-$$version 2>&1 \
			&& echo "installed and planned on Python $$version" \
			|| { tail -n 5 dist/log-$$version; echo "Python $$version failed"; exit 1; } ) & \
		tries="$$tries $$!"; \
	done; \
	for try in $$tries; do wait $$try || failed=yes; done; test -z "$$failed"

release: INSTALLED = dist/*.tar.gz
pythons: INSTALLED = .

# the package comes from .venv if that has the same Python, which saves compiling it. Messages stay on this machine
doors: .venv/ready
	@python=$$(for p in python3.11 "$${PYENV_ROOT:-$$HOME/.pyenv}"/versions/3.11.*/bin/python $(abspath $(BIN)/python); do \
		"$$p" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null && { echo "$$p"; break; }; done); \
	test -n "$$python" || { echo "no Python 3.11 here: the ROS 2 node was not tried"; exit 0; }; \
	set -e; \
	cmp -s doors.lock build/doors/doors.lock || { \
		"$$python" -m venv --clear build/doors; \
		$(DOORS) -m pip install --quiet --no-compile --disable-pip-version-check --require-hashes -r doors.lock; \
		cp doors.lock build/doors; }; \
	place=$$($(DOORS) -c 'import sysconfig; print(sysconfig.get_path("purelib"))'); rm -rf "$$place"/gabf_planner*; \
	cp -r .venv/lib/python3.11/site-packages/gabf_planner* "$$place" 2>/dev/null \
		|| $(DOORS) -m pip install --quiet --no-compile --disable-pip-version-check --no-deps .; \
	ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST $(DOORS) -m pytest --confcutdir=tests/doors tests/doors

.venv/ready: .venv/packages $(BUILD) $(NATIVE)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --no-deps --editable .
	touch .venv/ready

.venv/packages: requirements.lock compiler.lock
	@test -n "$(PYTHON)" || { echo "planner needs Python 3.11, 3.12 or 3.13: install one, or run 'make PYTHON=/path/to/python3.12'."; exit 1; }
	@"$(PYTHON)" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null \
		|| { echo "planner needs Python 3.11, 3.12 or 3.13, and $(PYTHON) is none of them."; exit 1; }
	@test ! -L .venv || { echo ".venv is a link, and the environment behind it is not that of this tree's lock files: set it up there."; exit 1; }
	"$(PYTHON)" -m venv --clear .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	@command -v c++ >/dev/null || command -v g++ >/dev/null || command -v clang++ >/dev/null || { \
		echo "no C++ compiler here: one comes as a Python package, and takes a minute the first time"; \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r compiler.lock; }
	touch .venv/packages

# the lock file holds every package with its hashes, for Python 3.11 to 3.13, and no address of a registry
lock:
	uv pip compile --quiet --universal --no-strip-extras --python-version 3.11 --generate-hashes --no-emit-index-url --no-annotate \
		--custom-compile-command "make lock" --extra clouds --extra figures --extra interop --extra mjcf --extra xacro --extra notebooks --extra cluster --group dev --group docs pyproject.toml -o requirements.lock
	uv pip compile --quiet --no-strip-extras --python-version 3.11 --python-platform x86_64-manylinux_2_28 --generate-hashes --no-emit-index-url \
		--no-annotate --custom-compile-command "make lock" --constraint requirements.lock --extra ros --group doors pyproject.toml -o doors.lock
	echo 'ziglang>=0.13' | uv pip compile --quiet --universal --no-strip-extras --python-version 3.11 --generate-hashes --no-emit-index-url \
		--no-annotate --custom-compile-command "make lock" - -o compiler.lock

clean:
	rm -rf .venv out build dist docs/_build
