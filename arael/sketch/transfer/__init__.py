"""What refers to an entity that is cut or shortened, carried over to what takes its place."""
