"""The `arael` command."""
