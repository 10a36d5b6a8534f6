# Targets for developers; `make help` lists them. The default Python is python3, which must be 3.11 or 3.13.
PYTHON ?= python3
VENV := .venv/$(or $(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null),none)
STAMP := $(VENV)/.stamp
BENCH := $(VENV)-bench
FARM := $(VENV)-farm
SITE := 'import site; print(site.getsitepackages()[0])'

.PHONY: help demo compare demo-field demo-cones test test-blender test-farm bench zip lint clean
help:            ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-13s %s\n", $$1, $$2 }' Makefile

$(STAMP): tools/requirements.txt tools/make_venv.sh
	@tools/make_venv.sh $(PYTHON) $(VENV)
	@touch $@

demo: $(STAMP)   ## bake and render the demo scene into out/demo/
	$(VENV)/bin/python demo/run.py

compare: $(STAMP)   ## every model of the bounces beside path tracing, into out/compare/; ARGS: --quick, --update-docs
	$(VENV)/bin/python demo/compare.py $(ARGS)

demo-field: $(STAMP)   ## AO fields of moving props, in EEVEE and Cycles beside ray-traced AO, into out/demo-field/
	$(VENV)/bin/python demo/field_demo.py

demo-cones: $(STAMP)   ## the World's light by bent cones, beside path tracing, into out/bent_cones/; ARGS: --update-docs
	$(VENV)/bin/python demo/bent_cones.py $(ARGS)

# A process a core, each with a Blender of its own; four at most, since bakes take all cores themselves.
test: $(STAMP)   ## run the tests in the bpy module; ARGS go to pytest
	$(VENV)/bin/python -m pytest --numprocesses auto --maxprocesses 4 --dist worksteal $(ARGS)

test-blender: $(STAMP)   ## the same in a real Blender, on the built zip; BLENDER, else the PATH's, else fetched
	tools/test_in_blender.sh $(VENV) $(ARGS)

$(FARM)/.stamp: $(STAMP) tools/farm_requirements.txt
	$(VENV)/bin/python -m venv --clear $(FARM)
	$(FARM)/bin/python -m pip install --quiet --disable-pip-version-check -r tools/farm_requirements.txt
	@touch $@

test-farm: $(FARM)/.stamp   ## run the job templates of farm/ by openjd, in a real Blender as test-blender has it
	OPENJD=$(abspath $(FARM)/bin/openjd) tools/test_in_blender.sh $(VENV) tests/farm/farm_jobs.py $(ARGS)

# The benchmarks' own packages lie beside those of the venv, so that the tests do without them.
$(BENCH)/.stamp: $(STAMP) tools/bench_requirements.txt
	$(VENV)/bin/python -m venv --clear $(BENCH)
	$(VENV)/bin/python -c $(SITE) > $$($(BENCH)/bin/python -c $(SITE))/blender.pth
	$(BENCH)/bin/python -m pip install --quiet --disable-pip-version-check -r tools/bench_requirements.txt
	@touch $@

bench: $(BENCH)/.stamp   ## run the benchmarks; ARGS: names of some, --quick, --update-docs
	$(BENCH)/bin/python tests/benchmarks/run.py $(ARGS)

zip: $(STAMP)    ## build the installable zips into dist/
	$(VENV)/bin/python tools/build_zip.py

lint: $(STAMP)   ## check the style
	$(VENV)/bin/ruff check .

clean:           ## remove what the other targets made
	rm -rf build dist out wheels .venv .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
