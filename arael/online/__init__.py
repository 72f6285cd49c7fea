"""Online solving: `Model.update` takes in what has changed since the last call."""
