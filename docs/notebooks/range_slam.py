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
# # Range SLAM
#
# A robot measures its own motion and its distance to radio beacons, nothing else: no bearings, no map. The path and the places of the beacons are the unknowns.
#
# The page [Range SLAM](../problems/range_slam.md) explains the model and the results; `examples/range_slam` makes the data.

# %% [markdown]
# The model, as the file `range_slam.arael` has it:

# %%
import arael

Model = arael.loads('''
# A robot that measures only distances to radio beacons, and its own motion. Neither its path nor the
# places of the beacons are known; all ranges have a common scale, and some are wild.

struct Pose {
    param pos: vec2 [m]
    param th:  angle [rad]
}

struct Beacon {
    id: int
    param pos: vec2 [m]
}

# Odometry between consecutive poses, in the frame of the first.
struct Step {
    a:      ref Pose in root.poses
    b:      ref Pose in root.poses
    moved:  vec2 [m]
    turned: real [rad]
    moved_isigma:  vec2 [1/m]          # forward, sideways
    turned_isigma: real [1/rad]

    constraint odometry {
        let c = cos(a.th)
        let s = sin(a.th)
        let d = b.pos - a.pos
        [(c * d.x + s * d.y - moved.x) * moved_isigma.x,
         (c * d.y - s * d.x - moved.y) * moved_isigma.y,
         rad_diff(b.th - a.th, turned) * turned_isigma]
    }
}

struct Range {
    pose:   ref Pose in root.poses
    beacon: ref Beacon in root.beacons
    range:  real [m]

    constraint range loss cauchy(root.outlier) {
        (root.scale * norm(beacon.pos - pose.pos) - self.range) / root.range_sigma
    }
}

root RangeSlam {
    param scale: real = 1              # of all ranges: the radio's clock, the speed of its signal
    poses:   list of Pose
    beacons: list of Beacon
    steps:   list of Step
    ranges:  list of Range

    range_sigma: real [m] = 0.6
    outlier:     real     = 3          # residuals beyond this many sigmas lose influence

    prior scale ~ normal(1, 0.1)
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/range_slam.npz")
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
# The beacons, with their standard errors:

# %%
model.covariance().marginals("beacons").diagonal(axis1=1, axis2=2) ** 0.5

# %% [markdown]
# Pictures of the solution and of its residuals, in standard deviations:

# %%
model.plot()

# %%
model.plot("residuals")
