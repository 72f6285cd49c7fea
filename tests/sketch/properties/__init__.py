"""Properties that hold for every sketch: random ones, exact ones, published linkages."""
