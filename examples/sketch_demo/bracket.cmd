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

# Bolt holes, one at each corner, all of one size.
a = add_circle 10,10 3
b = add_circle 70,10 3
c = add_circle 70,40 3
d = add_circle 10,40 3
radius a 3 mm
equal a b; equal a c; equal a d
hdistance bottom.p1 a.center margin
vdistance bottom.p1 a.center margin
horizontal a.center b.center
hdistance b.center bottom.p2 margin
vertical b.center c.center
vdistance c.center right.p2 margin
horizontal c.center d.center
vertical d.center a.center

# A slot beside the bore, on its height; the lines meet the arcs, which become tangent by themselves.
upper = add_line 60,27.5 66,27.5
lower = add_line 66,22.5 60,22.5
outer = add_arc upper.p2 lower.p1 68.5,25
inner = add_arc lower.p2 upper.p1 57.5,25
horizontal upper
length upper width/10
radius inner 2.5 mm; equal inner outer
horizontal bore.center inner.center
hdistance bore.center inner.center bore.radius+5

# The corners of the plate.
fillet bottom right right top top left left bottom 6 mm
