"""Where a cost comes from, what is free, how certain the solution is."""
