include "totals.pxd"
include "union_find.pxd"
