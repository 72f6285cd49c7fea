"""What a sketch is: entities, constraints, dimensions, parameters, groups; undo; JSON."""
