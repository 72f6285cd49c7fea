"""Tests of models that consist of independent problems."""
