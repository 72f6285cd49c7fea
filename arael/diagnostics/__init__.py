"""Diagnostics about user input: records, renderers and explanations."""
