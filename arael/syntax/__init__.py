"""Parser and formatter of model files."""
