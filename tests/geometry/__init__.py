"""Tests of arael.geometry."""
