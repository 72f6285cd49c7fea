"""Solves with rows that hold exactly: `require` of a model, and bounds."""
