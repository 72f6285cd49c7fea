"""Agents: the sketch as a server of the Model Context Protocol."""
