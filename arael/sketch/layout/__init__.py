"""From a sketch's document to the rows that are solved, and back."""
