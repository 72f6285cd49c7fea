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
# # Spline trajectories
#
# Sensors measure at their own times: positions at 20 Hz, attitudes at 15 Hz. A trajectory that is a function of time takes each measurement where it belongs, without interpolated measurements and without a state for each of them.
#
# The page [Spline trajectories](../problems/spline_trajectory.md) explains the model and the results; `examples/spline_trajectory` makes the data.

# %% [markdown]
# The model, as the file `spline_trajectory.arael` has it:

# %%
import arael

Model = arael.loads('''
# A continuous trajectory: a uniform cubic B-spline on SE(3) in cumulative form (Kim, Kim, Shin 1995;
# Lovegrove, Patron-Perez, Sibley 2013). Sensors measure at their own times.

struct Knot {
    param T: transform                       # body to world
}

# The fraction `w` of the motion from one knot to the next.
fn part(a, b, w) = exp(w * (a.inverse() * b).log())

# The pose at `u`, from 0 to 1, between the second and the third of four knots.
fn spline(a, b, c, d, u) = a * part(a, b, (5 + 3 * u - 3 * u^2 + u^3) / 6) *
    part(b, c, (1 + 3 * u + 3 * u^2 - 2 * u^3) / 6) * part(c, d, u^3 / 6)

# A position and an attitude, or one of them: the other has the weight zero.
struct Sample {
    u:     real
    knots: [ref Knot in root.knots; 4]
    pos:   vec3 [m]
    q:     quat
    pos_isigma: real [1/m]   = 0
    q_isigma:   real [1/rad] = 0

    constraint pose {
        let T = spline(knots[0].T, knots[1].T, knots[2].T, knots[3].T, u)
        [(T.translation - pos) * pos_isigma, (q.conj() * T.rotation).log() * q_isigma]
    }
}

root Trajectory {
    knots:   list of Knot
    samples: list of Sample
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/spline_trajectory.npz")
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
