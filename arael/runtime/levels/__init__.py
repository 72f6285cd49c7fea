"""Equations solved exactly, then lower levels in what they leave free."""
