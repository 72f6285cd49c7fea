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
# # Satellite receiver
#
# A receiver measures pseudoranges: distances to satellites, plus the error of its clock. Each epoch is a problem of four unknowns.
#
# The page [Satellite receiver](../problems/gnss.md) explains the model and the results; `examples/gnss` makes the data.

# %% [markdown]
# The model, as the file `gnss.arael` has it:

# %%
import arael

Model = arael.loads('''
# Single epochs of a satellite receiver: position and clock from pseudoranges, each epoch on its own.

struct Satellite {
    pos:    vec3 [m]                     # at the time of transmission, earth-centred
    range:  real [m]                     # measured: the distance, and the receiver's clock
    isigma: real [1/m]                   # low satellites are noisier

    constraint pseudorange loss cauchy(root.outlier) {
        (norm(pos - parent.pos) + parent.clock - self.range) * isigma
    }
}

struct Epoch {
    param pos:   vec3 [m] = [0, 0, 0]    # the centre of the earth is near enough as a start
    param clock: real [m] = 0            # error of the clock times the speed of light
    satellites: list of Satellite
}

root Gnss {
    epochs:  list of Epoch
    outlier: real = 3

    # Far from the solution every residual is large: no loss there.
    solve {
        pass rough { outlier = 1e9 }
        pass wide  { outlier = 20 }
        pass fine  { outlier = 3 }
    }
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/gnss.npz")
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
# Each epoch is a component with an end of its own.

# %%
result.components

# %% [markdown]
# Pictures of the solution and of its residuals, in standard deviations:

# %%
model.plot()

# %%
model.plot("residuals")
