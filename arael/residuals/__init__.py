"""Residuals written as text while a program runs."""
