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
# # Calibration of an arm
#
# The links of a robot differ from their drawing by fractions of a millimetre and milliradians. A tracker measures the position of a point on the tool in many postures, from which the Denavit-Hartenberg parameters are found: four for each of the seven joints.
#
# The page [Calibration of an arm](../problems/arm_calibration.md) explains the model and the results; `examples/arm_calibration` makes the data.

# %% [markdown]
# The model, as the file `arm_calibration.arael` has it:

# %%
import arael

Model = arael.loads('''
# Calibration of an arm of seven joints: the Denavit-Hartenberg parameters of its links, the frame of
# the instrument, and the point on the tool whose position the instrument measures.

# Moves a point from the frame of a link to that of the link before.
fn link(q, a, d, alpha, p) = rotation_matrix([0, 0, q]) * (rotation_matrix([alpha, 0, 0]) * p + [a, 0, d])

# What is known of a link before: its drawing and the tolerances of its manufacture.
struct Drawing {
    theta:        real [rad]
    d:            real [m]
    a:            real [m]
    alpha:        real [rad]
    angle_sigma:  real [rad]
    length_sigma: real [m]
}

struct Joint {
    param theta: real [rad] = 0     # offset of the encoder
    param d:     real [m]   = 0     # along the axis of the joint
    param a:     real [m]   = 0     # from this axis to the next
    param alpha: real [rad] = 0     # between the two axes
    drawing: Drawing?

    prior theta ~ normal(drawing.theta, drawing.angle_sigma) when drawing
    prior d ~ normal(drawing.d, drawing.length_sigma) when drawing
    prior a ~ normal(drawing.a, drawing.length_sigma) when drawing
    prior alpha ~ normal(drawing.alpha, drawing.angle_sigma) when drawing
}

struct Shot {
    q:    vec<7> [rad]              # readings of the encoders
    seen: vec3 [m]                  # the point on the tool, in the frame of the instrument

    constraint position {
        let j  = root.chain
        let p6 = link(q[6] + j[6].theta, j[6].a, j[6].d, j[6].alpha, root.tool)
        let p5 = link(q[5] + j[5].theta, j[5].a, j[5].d, j[5].alpha, p6)
        let p4 = link(q[4] + j[4].theta, j[4].a, j[4].d, j[4].alpha, p5)
        let p3 = link(q[3] + j[3].theta, j[3].a, j[3].d, j[3].alpha, p4)
        let p2 = link(q[2] + j[2].theta, j[2].a, j[2].d, j[2].alpha, p3)
        let p1 = link(q[1] + j[1].theta, j[1].a, j[1].d, j[1].alpha, p2)
        let p0 = link(q[0] + j[0].theta, j[0].a, j[0].d, j[0].alpha, p1)
        (root.base * p0 - seen) / root.sigma
    }
}

root Arm {
    param base: transform = [0, 0, 0, 1, 0, 0, 0]   # arm in the frame of the instrument
    param tool: vec3 [m]                            # the point, in the frame of the last link
    joints: list of Joint
    chain:  [ref Joint in root.joints; 7]
    shots:  list of Shot
    sigma:  real [m] = 1e-4
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/arm_calibration.json.gz")
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
# The Jacobian, a line for each constraint:

# %%
model.jacobian()

# %% [markdown]
# Pictures of the solution and of its residuals, in standard deviations:

# %%
model.plot()

# %%
model.plot("residuals")
