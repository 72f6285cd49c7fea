"""Representations of models and results in terminals and notebooks."""
