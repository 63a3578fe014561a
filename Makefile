# make study    run the example study into runs/vane
# make test     run every test
# Each makes the environment in .venv first, once.

# The files that take longest come first (conftest.py), or one of them would run alone at the end.
PYTEST := .venv/bin/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder --durations=20
VERIFIED := tests/verification
SMOKE := "tests/golden/test_golden.py::test_a_run_finds_what_it_found[default]" \
  $(VERIFIED)/mesh/test_designs.py::test_sets_have_the_counts_asked_for_and_share_no_node \
  $(VERIFIED)/fem/test_patch.py $(VERIFIED)/rom/test_free_structures.py \
  "$(VERIFIED)/nonlinear/laws/test_nlvib.py::test_its_points_are_solutions_here"
MADE := .venv/made

# Children of tests and of both test processes read what one of them has compiled.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: study test test-system smoke verify benchmarks docs wheel lint setup lock

study: $(MADE)
	.venv/bin/vanelock run examples/vane.toml --output runs/vane

# All that shows the program right. A skipped test counts as failed: what ships is what was tested.
test: $(MADE)
	$(PYTEST) --everything -m "not system"

# What needs processes, signals, kills, full disks, clusters or environments of its own.
test-system: $(MADE)
	$(PYTEST) --everything -m system tests

# A minute: a study at the coarsest mesh, and a verification of each of the four of the physics.
smoke: $(MADE)
	$(PYTEST) --everything $(SMOKE)

# Every verification at full count; rewrites docs/verification.
verify: $(MADE)
	VANELOCK_VERIFY=full $(PYTEST) -o faulthandler_timeout=3600 --everything tests/verification
	.venv/bin/python tools/evidence.py

# Every benchmark, some hours, or PAGES="optimum stability"; rewrites docs/benchmarks.
benchmarks: $(MADE)
	.venv/bin/python tools/evidence.py --run $(PAGES)

# The manual, into build/docs; a warning is an error.
docs: $(MADE)
	.venv/bin/python -m sphinx -q -W --keep-going docs build/docs
	@echo "build/docs/index.html"

# sdist and wheel into dist/, each tried in empty environments; prints what was found.
wheel: $(MADE)
	.venv/bin/python tools/wheel.py

lint: $(MADE)
	.venv/bin/python -m ruff check
	.venv/bin/python -m ruff format --check
	.venv/bin/python -m mypy
	.venv/bin/lint-imports
	git ls-files '*.py' '*.md' '*.toml' '*.js' '*.html' '*.css' | xargs .venv/bin/codespell
	.venv/bin/python tools/words.py
	.venv/bin/python tools/budget.py

setup: $(MADE)

# The environment knows the folder it was made in: a moved or copied checkout makes its own.
ifneq "$(shell cat $(MADE) 2>/dev/null)" "$(CURDIR)"
.PHONY: $(MADE)
endif

$(MADE): pyproject.toml requirements.lock tools/setup.sh tools/environment.py tools/system_packages.py
	sh tools/setup.sh

# The newest versions that pyproject.toml allows become the pinned ones, each with the digests of
# all its files; what is for CHOLMOD or PARDISO alone stands apart.
lock: $(MADE)
	.venv/bin/python tools/lock.py
