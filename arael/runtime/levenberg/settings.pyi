"""Settings of a solve as plain C, and the ways in which it may end."""

STATUSES: tuple[str, ...]
