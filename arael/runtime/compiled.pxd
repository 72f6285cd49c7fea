include "interruption.pxd"
