"""Many problems, and one in parts, on Dask."""
