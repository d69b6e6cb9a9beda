# The words people type: `just` lists them.

bin := ".venv/bin"

# List the recipes.
default:
    @just --list

# Create the environment with the versions that the tests last passed with.
setup:
    python3 -m venv .venv
    {{bin}}/pip install -q -e '.[dev]' -c constraints.txt

# Run the quick tests; arguments go to pytest.
test *arguments:
    {{bin}}/pytest -n 2 -q {{arguments}}

# Run lint, format, types, import directions and all tests.
check:
    scripts/check

# Build the documentation site; every warning is an error.
site:
    scripts/site

# Draw mutants by a seed, and report which of them no test kills.
mutants drawn="12" seed="a":
    {{bin}}/python scripts/mutation --drawn {{drawn}} --seed {{seed}}

# List the benchmarks.
benchmarks:
    {{bin}}/python -m benchmarks
