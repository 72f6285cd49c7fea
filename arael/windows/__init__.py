"""Windows that slide: rows that leave a model become a prior on their neighbours."""
