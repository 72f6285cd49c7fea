include "analysis.pxd"
include "factor.pxd"
include "scaled_factor.pxd"
include "rank_qr.pxd"
