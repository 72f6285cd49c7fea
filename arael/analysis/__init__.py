"""Cost by constraint, free directions, uncertainty of a solution."""
