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
# # Hand-eye calibration
#
# A camera is mounted on the hand of a robot. The robot knows the poses of its hand, the camera those of itself relative to a target; where the camera is on the hand is not known.
#
# The page [Hand-eye calibration](../problems/hand_eye.md) explains the model and the results; `examples/hand_eye` makes the data.

# %% [markdown]
# The model, as the file `robot_world.arael` has it:

# %%
import arael

Model = arael.loads('''
# Camera on the hand of a robot, and a target in its workspace: A X = Y B.

struct Shot {
    a_t: vec3 [m]           # hand in the frame of the robot
    a_q: quat
    b_t: vec3 [m]           # camera in the frame of the target
    b_q: quat

    # Both sides are the pose of the camera in the frame of the robot.
    constraint chain {
        let a = transform(a_t, a_q)
        let b = transform(b_t, b_q)
        ((a * root.X).inverse() * (root.Y * b)).log() .* root.isigma
    }
}

root RobotWorld {
    param X: transform = [0, 0, 0, 1, 0, 0, 0]      # camera in the frame of the hand
    param Y: transform = [0, 0, 0, 1, 0, 0, 0]      # target in the frame of the robot
    shots:  list of Shot
    isigma: vec<6> = [1000, 1000, 1000, 1000, 1000, 1000]   # of a pose of the camera, in its frame
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/hand_eye.json.gz")
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
