# ---
# jupyter:
#   jupytext:
#     formats: py:percent,ipynb
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Ranges by a clock of their own
#
# A radio measures ranges to beacons and stamps them by its own clock, beside a path of positions. Offset and skew of the clock, the delay of the radio and the places of the beacons are not known.
#
# The page [Ranges by a clock of their own](../problems/range_clocks.md) explains the model and the results; `examples/range_clocks` makes the data.

# %% [markdown]
# The model, as the file `range_clocks.arael` has it:

# %%
import arael

Model = arael.loads('''
# Ranges to radio beacons, stamped by a clock of the radio's own, beside positions of another sensor: offset
# and skew of the clock, delay of the radio, beacons, and the path as a spline.

# A control point of the path, a uniform cubic B-spline.
struct Knot {
    key t
    t: real [s]             # by the clock of the positions
    param pos: vec2 [m]
}

struct Fix {
    t:   real [s]
    pos: vec2 [m]

    constraint near {
        (root.knots.at(t, pos, bspline(4)) - pos) / root.fix_sigma
    }
}

struct Beacon {
    param pos: vec2 [m]
}

struct Range {
    time:   real [s]        # by the clock of the radio
    beacon: ref Beacon in root.beacons
    range:  real [m]

    constraint range {
        let t     = time + root.offset + root.skew * (time - root.middle)
        let place = root.knots.at(t, pos, bspline(4))
        (norm(beacon.pos - place) + root.delay - self.range) / root.range_sigma
    }
}

root Radio {
    knots:       list of Knot
    beacons:     list of Beacon
    fixes:       list of Fix
    ranges:      list of Range
    fix_sigma:   real [m] = 0.02
    range_sigma: real [m] = 0.05
    middle:      real [s] = 0           # by the clock of the radio
    param offset: real [s] = 0          # added to times of the radio, at the middle
    param skew:   real = 0              # by which the clock of the positions is faster
    param delay:  real [m] = 0          # of the radio, as a distance
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/range_clocks.npz")
model

# %% [markdown]
# The solve:

# %%
result = model.solve()
result

# %% [markdown]
# Parameters with standard errors, and how well the model fits:

# %%
model.report()

# %% [markdown]
# Pictures of the solution and of its residuals, in standard deviations:

# %%
model.plot()

# %%
model.plot("residuals")
