from libc.stdint cimport int32_t, int64_t, uint8_t

include "lists.pxd"
include "tree.pxd"
include "linearisations.pxd"
