"""`python -m arael`: the command line where the `arael` script is not on the path."""

from arael.cli.main import main

if __name__ == "__main__":
    main()
