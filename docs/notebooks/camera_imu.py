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
# # Camera and IMU
#
# A camera with a rolling shutter and an IMU are fixed to each other and have clocks of their own. Their mounting, the offset of the clocks, the delay of a line, gravity, the biases and the motion are not known.
#
# The page [Camera and IMU](../problems/camera_imu.md) explains the model and the results; `examples/camera_imu` makes the data.

# %% [markdown]
# The model, as the file `camera_imu.arael` has it:

# %%
import arael

Model = arael.loads('''
# A camera and an IMU that are fixed to each other, each with a clock of its own: their mounting, the offset of
# the clocks, gravity, biases, and the time that the camera's shutter takes from line to line.

# A control point of the motion of the IMU in the frame of the target, a uniform cubic B-spline.
struct Knot {
    key t
    t: real [s]             # by the clock of the IMU
    param pos:  vec3 [m]
    param turn: rotation    # from the IMU to the target
}

struct Sample {
    t:    real [s]
    gyro: vec3 [rad/s]
    acc:  vec3 [m/s^2]

    constraint imu {
        let R     = root.knots.at(t, turn, bspline(4)).rotation_matrix()
        let force = R' * (root.knots.acceleration(t, pos, bspline(4)) - root.gravity)
        [(root.knots.rate(t, turn, bspline(4)) + root.gyro_bias - gyro) / root.gyro_sigma,
         (force + root.acc_bias - acc) / root.acc_sigma]
    }
}

struct Corner {
    pos: vec3 [m]           # in the frame of the target
}

struct Sight {
    time:   real [s]        # of the first line, by the clock of the camera
    corner: ref Corner in root.corners
    pixel:  vec2            # column, line

    constraint seen {
        let t = time + root.offset + root.line_delay * pixel.y
        let R = root.knots.at(t, turn, bspline(4)).rotation_matrix()
        let p = R' * (corner.pos - root.knots.at(t, pos, bspline(4)))
        let c = root.mount.rotation_matrix()' * (p - root.lever)
        (root.focal * [c.x, c.y] / c.z + root.centre - pixel) / root.pixel_sigma
    }
}

root Rig {
    knots:       list of Knot
    samples:     list of Sample
    corners:     list of Corner
    sights:      list of Sight
    focal:       real = 300
    centre:      vec2 = [320, 240]
    pixel_sigma: real = 0.15
    gyro_sigma:  real [rad/s] = 0.001
    acc_sigma:   real [m/s^2] = 0.02
    param mount:      rotation = [1, 0, 0, 0]           # from the camera to the IMU
    param lever:      vec3 [m]     = [0, 0, 0]          # camera in the frame of the IMU
    param gravity:    vec3 [m/s^2] = [0, 0, -9.81]      # in the frame of the target
    param gyro_bias:  vec3 [rad/s] = [0, 0, 0]
    param acc_bias:   vec3 [m/s^2] = [0, 0, 0]
    param offset:     real [s]     = 0                  # added to times of the camera
    param line_delay: real [s]     = 0                  # from one line to the next
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/camera_imu.npz")
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
