"""Systems that solve the same problems, each in a process of its own."""
