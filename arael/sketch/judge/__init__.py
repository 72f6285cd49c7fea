"""What is free, what is redundant, what cannot be, in words."""
