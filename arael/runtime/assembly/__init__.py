"""Where the contributions of instances go: structure, offsets, first writers, shares."""
