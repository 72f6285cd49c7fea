# A bracket: a plate with rounded corners, four bolt holes and a large bore, all from two numbers.
param width 80 mm
param height 50 mm
param margin 10 mm

# The outline, its lower left corner at the origin.
bottom, right, top, left = add_rect 0,0 80,50 hv
lock bottom.p1 0,0
length bottom width
length right height

# The bore in the middle.
bore = add_circle 40,25 12
hdistance bottom.p1 bore.center width/2
vdistance bottom.p1 bore.center height/2
radius bore min(width,height)/4

# A bolt hole at each corner: copies of one, whose distances follow the sizes of the plate.
hole = add_circle 10,10 3
radius hole 3 mm
hdistance bottom.p1 hole.center margin
vdistance bottom.p1 hole.center margin
beside, above, far = pattern rect hole 2 width-2*margin by 2 height-2*margin

# A slot beside the bore, on its height.
lower, upper, outer, inner = add_slot 60,25 66,25 2.5
horizontal upper
length upper width/10
radius inner 2.5 mm
horizontal bore.center inner.center
hdistance bore.center inner.center bore.radius+5

# The corners of the plate.
fillet bottom right right top top left left bottom 6 mm
