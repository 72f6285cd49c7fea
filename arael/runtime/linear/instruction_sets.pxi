"""The instruction set of the dense kernels and of the block elimination: chosen once, at import."""

# By name, of those that are compiled and that this processor runs, the best one last.
cdef dict usable_sets = {
    (<bytes>kernel_sets[k].name).decode(): k
    for k in range(KERNEL_SETS) if kernel_sets[k].runs_here()
}


def instruction_sets():
    """Names of the usable instruction sets, the best one last."""
    return tuple(usable_sets)


def use_instruction_set(name):
    """Select the kernels of instruction set `name` for the whole process."""
    if name not in usable_sets:
        raise ValueError(f"instruction set {name!r} is not among {instruction_sets()}")
    take_tiles(usable_sets[name])
    take_blocks(usable_sets[name])


use_instruction_set(list(usable_sets).pop())
