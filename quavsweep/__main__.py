"""`python -m quavsweep`."""

from quavsweep.cli import main

if __name__ == "__main__":
    main()
