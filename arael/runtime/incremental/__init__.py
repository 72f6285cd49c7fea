"""A factor that is kept while rows come and go: `Model.update` solves with it."""
