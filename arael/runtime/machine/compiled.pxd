include "natives.pxd"
include "program.pxd"
include "tape_program.pxd"
