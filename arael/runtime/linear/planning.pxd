include "front_time.pxd"
include "siblings.pxd"
include "trees.pxd"
