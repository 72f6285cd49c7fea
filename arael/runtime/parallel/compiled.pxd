include "kept.pxd"
include "pool.pxd"
