"""Faults around real processes: signals, disks, caches, compilers, limits, threads.

After each: nothing is lost, nothing is left over, and a message names the cause.
"""
