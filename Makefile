# echolot: what one can do here. `make` alone lists it.

ECHOLOT = cargo run --quiet --release -p experiments --bin echolot --

.PHONY: help sim-experiments sim-landmarks sim-quick sim-ensemble sim-ensemble-field sim-letter figures bound picture \
	claims reference validate test audio-test check fuzz robustness bench bless python python-test

help: ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 20

LANDMARKS = $(patsubst %,studies/papers/landmarks_%.json,periods noise site)

sim-experiments: ## simulate and reproduce the papers' studies in their size, landmarks too (results/paper, landmarks_*)
	$(ECHOLOT) run studies/papers/paper.json $(LANDMARKS)

sim-landmarks: ## landmarks and SLAM alone (results/landmarks_*), on the same recordings
	$(ECHOLOT) run $(LANDMARKS)

sim-quick: ## the same chain in a small scene, and all methods by image sources (results/quick, results/methods)
	$(ECHOLOT) run studies/quick

sim-ensemble: ## in what share of 100 random layouts the claims hold, by image sources (results/ensemble)
	$(ECHOLOT) run studies/papers/ensemble.json

sim-ensemble-field: ## the same on the field, in a few of these layouts (results/ensemble_field)
	$(ECHOLOT) run studies/papers/ensemble_field.json

sim-letter: ## the 2024 paper with every choice as it prints it, on the field (results/letter, results/letter_scheme)
	$(ECHOLOT) run studies/papers/letter.json studies/papers/letter_scheme.json

figures: ## redraw all figures from the data files, without computing anything
	@for folder in paper quick methods bench bound; do \
		if [ -d results/$$folder ]; then $(ECHOLOT) figures results/$$folder || exit 1; fi; \
	done
	@if [ -d results/validation/data ]; then $(ECHOLOT) validate --figures-only; fi

bound: ## what a landmark's echo is off by, beside the Cramer-Rao bound (results/bound)
	@mkdir -p results/bound/data
	cargo run --quiet --release -p localizer --example landmark_bound > results/bound/data/landmark_bound.csv.part
	@mv results/bound/data/landmark_bound.csv.part results/bound/data/landmark_bound.csv
	$(ECHOLOT) figures results/bound

picture: ## the sound field that README shows (results/field.png)
	$(ECHOLOT) scene draw scenes/four_walls.json --click localization --after 0.0085 -o results/field.png

validate: ## compare the field with laws of physics, all cases (results/validation)
	$(ECHOLOT) validate --full

claims: ## compare the summary with the papers' claims (results/paper/report.md, tables of README.md)
	$(ECHOLOT) check studies/papers/paper.json --into README.md

reference: ## the command line as a page of the documents (docs/reference/command-line.md)
	$(ECHOLOT) reference -o docs/reference/command-line.md

test: ## all tests
	cargo test --release

audio-test: ## what plays and records on sound devices (feature audio; Linux needs libasound2-dev)
	cargo test --release -p experiments --features audio --lib -- live::audio
	cargo test --release -p experiments --features audio --test echolot -- audio

check: ## formatting, lints, tests
	cargo fmt --all --check
	cargo clippy --release --workspace --all-targets -- -D warnings
	cargo test --release

fuzz: ## mutated files for every parser, INPUTS=1000000 each
	BOLERO_RANDOM_ITERATIONS=$(or $(INPUTS),1000000) cargo test --release -p fuzz -- --nocapture

robustness: ## wrong inputs, mutated files, kills, full disks, flipped bits in full number (docs/validation/robustness.md)
	@rm -f target/tried.jsonl
	ECHOLOT_TRIED=$(CURDIR)/target/tried.jsonl $(MAKE) fuzz
	ECHOLOT_TRIED=$(CURDIR)/target/tried.jsonl ECHOLOT_MOMENTS=$(or $(MOMENTS),100) \
		cargo test --release -p experiments --test echolot -- --nocapture faults inputs files trust code studies
	$(ECHOLOT) robustness target/tried.jsonl -o docs/validation/robustness.md

bench: ## benchmarks and the speed of the engines (results/bench); BENCH="--measurement-time 1" is quicker
	cargo bench -p benches -- $(BENCH)
	$(ECHOLOT) bench

bless: ## make the present quick results the baseline of the regression gate
	$(ECHOLOT) check studies/quick --bless

PYTHON = target/python/bin/python

$(PYTHON):
	python3 -m venv target/python

python: $(PYTHON) ## the Python package, in a virtual environment (target/python)
	$(PYTHON) -m pip install --quiet './python[plot]'

python-test: $(PYTHON) ## its tests, examples, notebooks, types; EXTRAS=test,interchange adds other packages
	$(PYTHON) -m pip install --quiet './python[$(or $(EXTRAS),test)]'
	cd python && ../$(PYTHON) -m pytest
