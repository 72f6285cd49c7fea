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
