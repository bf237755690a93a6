"""How the promises are attacked: `python -m tests.faults`, and in small numbers by every run of the tests."""
