"""The instruction set of the dense kernels and of the block elimination: chosen once, at import."""

SETS = ("base", "avx2", "avx512")


def instruction_sets():
    """Names of the supported instruction sets, the best one last."""
    return SETS[: kernel_sets()]


def use_instruction_set(name):
    """Select the kernels of instruction set `name` for the whole process."""
    if name not in instruction_sets():
        raise ValueError(f"instruction set {name!r} is not among {instruction_sets()}")
    take_tiles(SETS.index(name))
    take_blocks(SETS.index(name))


take_tiles(kernel_sets() - 1)
take_blocks(kernel_sets() - 1)
