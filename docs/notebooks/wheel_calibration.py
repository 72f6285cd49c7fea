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
# # Wheels and a scanner
#
# The odometer of a robot and its laser scanner have clocks of their own. The place of the scanner, the scale of the wheels and the offset of the clocks are not known.
#
# The page [Wheels and a scanner](../problems/wheel_calibration.md) explains the model and the results; `examples/wheel_calibration` makes the data.

# %% [markdown]
# The model, as the file `wheel_calibration.arael` has it:

# %%
import arael

Model = arael.loads('''
# A laser scanner on a robot with wheels: its place, the scale of the wheels, the offset of the clocks.

# The path of the robot as its odometer integrates it, with wheels of nominal size.
struct Fix {
    key t
    t:   real [s]           # by the clock of the odometer
    pos: vec2 [m]
    yaw: real [rad]
}

# A motion of the scanner, from the alignment of two scans.
struct Motion {
    t0:   real [s]          # by the clock of the scanner
    t1:   real [s]
    step: vec2 [m]          # the second scan in the frame of the first
    turn: real [rad]

    constraint loop {
        let a = t0 + root.offset
        let b = t1 + root.offset
        let yaw = root.track.at(a, yaw, cubic)
        let turned = root.track.at(b, yaw, cubic) - yaw
        let driven = root.scale * (root.track.at(b, pos, cubic) - root.track.at(a, pos, cubic))
        let moved = rotation_matrix(turned) * root.lever + rotation_matrix(yaw)' * driven - root.lever
        [(rotation_matrix(root.mount)' * moved - step) / root.step_sigma,
         rad_diff(turned, turn) / root.turn_sigma]
    }
}

root Wheels {
    track:   list of Fix
    motions: list of Motion
    step_sigma: real [m] = 0.003
    turn_sigma: real [rad] = 0.001
    param lever:  vec2 [m] = [0, 0]     # scanner in the frame of the robot
    param mount:  angle = 0             # its heading there
    param scale:  real = 1              # of distances
    param offset: real [s] = 0          # added to times of the scanner
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/wheel_calibration.npz")
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
