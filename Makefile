# `make demo` and `make test` set up what they need, in a virtual environment, and run it.
# RFMS_VENV=DIRECTORY puts the environment elsewhere, RFMS_PYTHON=PROGRAM makes it with that Python.

VENV := $(or $(RFMS_VENV),.venv)
PIP := $(VENV)/bin/python -m pip install --quiet --disable-pip-version-check

.PHONY: demo test check generated clean

demo: $(VENV)/.installed
	@$(VENV)/bin/rfms demo

test: $(VENV)/.installed-dev
	@$(VENV)/bin/python tools/run_tests.py

check: $(VENV)/.installed-dev
	@$(VENV)/bin/python tools/run_tests.py --check

# What is made from the wire contract, the state tables and the verbs, in order; a few seconds.
generated: $(VENV)/.installed-dev
	@for tool in make_dbc draw_wire draw_states draw_node draw_cli draw_conform draw_link draw_candump \
	    draw_faults; do \
	    $(VENV)/bin/python tools/$$tool.py || exit 1; \
	done

clean:
	rm -rf build dist .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find rfms_can tests tools -name __pycache__ -type d -prune -exec rm -rf {} +

$(VENV)/.created:
	@tools/make-venv $(VENV)
	@touch $@

$(VENV)/.installed: pyproject.toml | $(VENV)/.created
	@echo "installing rfms_can into $(VENV): a minute or two the first time"
	@$(PIP) --editable .
	@touch $@

$(VENV)/.installed-dev: pyproject.toml | $(VENV)/.created
	@echo "installing rfms_can and its development tools into $(VENV): a minute or two the first time"
	@$(PIP) --editable '.[dev]'
	@touch $(VENV)/.installed $@
