"""Tests of the rows that are solved by levels."""
