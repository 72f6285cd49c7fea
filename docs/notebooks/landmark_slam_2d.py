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
# # Landmark SLAM in the plane
#
# A vehicle measures its own motion, and by a laser scanner ranges and bearings to trees; path and map are the unknowns.
#
# The page [Landmark SLAM in the plane](../problems/landmark_slam_2d.md) explains the model and the results; `examples/landmark_slam_2d` makes the data.

# %% [markdown]
# The model, as the file `landmark_slam_2d.arael` has it:

# %%
import arael

Model = arael.loads('''
# A vehicle in a plane that sees landmarks: odometry, and positions of landmarks in its own frame (a
# range and a bearing, which a laser scanner measures). Trees are recognised wrongly now and then.

struct Pose {
    param pos: vec2 [m]
    param th:  angle [rad]
}

struct Landmark {
    id: int
    param pos: vec2 [m]
}

# Motion between consecutive poses, in the frame of the first.
struct Step {
    a:      ref Pose in root.poses
    b:      ref Pose in root.poses
    moved:  vec2 [m]
    turned: real [rad]
    moved_isigma:  real [1/m]
    turned_isigma: real [1/rad]

    constraint odometry {
        let c = cos(a.th)
        let s = sin(a.th)
        let d = b.pos - a.pos
        [([c * d.x + s * d.y, c * d.y - s * d.x] - moved) * moved_isigma,
         rad_diff(b.th - a.th, turned) * turned_isigma]
    }
}

struct Sight {
    pose:     ref Pose in root.poses
    landmark: ref Landmark in root.landmarks
    bearing:  real [rad]
    range:    real [m]

    constraint sight loss cauchy(root.outlier) {
        let c = cos(pose.th)
        let s = sin(pose.th)
        let d = landmark.pos - pose.pos
        [rad_diff(atan2(c * d.y - s * d.x, c * d.x + s * d.y), bearing) / root.bearing_sigma,
         (norm(d) - range) / root.range_sigma]
    }
}

root LandmarkSlam {
    poses:     list of Pose
    landmarks: list of Landmark
    steps:     list of Step
    sights:    list of Sight

    bearing_sigma: real [rad] = deg2rad(2)
    range_sigma:   real [m]   = 0.3
    outlier:       real       = 2

    # The loss grows narrow when loops are nearly closed.
    solve {
        pass wide { outlier = 50 }
        pass fine { outlier = 2 }
    }
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/landmark_slam_2d.npz")
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
