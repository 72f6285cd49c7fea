"""The thread pool, and stacks that suffice for kernels."""
