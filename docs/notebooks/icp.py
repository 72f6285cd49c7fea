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
# # Iterated closest points
#
# Where was a scanner when it took its second scan? Points are matched with the nearest planes of the first scan, the transform that moves them onto the planes is solved for, and points are matched again.
#
# The page [Iterated closest points](../problems/icp.md) explains the model and the results; `examples/icp` makes the data.

# %% [markdown]
# The model, as the file `icp.arael` has it:

# %%
import arael

Model = arael.loads('''
# Iterated closest points: where a scan lies in the frame of another, from points and planes.

# A point of the moved scan, and the plane of the fixed scan that is nearest to it now.
struct Match {
    p: vec3 [m]             # of the moved scan, in its frame
    q: vec3 [m]             # of the plane
    n: vec3 [1]             # normal of the plane

    constraint plane loss geman_mcclure(root.reach) { dot(n, root.T * p - q) / root.sigma }
}

root Icp {
    param T: transform = [0, 0, 0, 1, 0, 0, 0]      # moved scan in the frame of the fixed one
    matches: list of Match
    sigma:   real [m] = 0.0055                      # of a distance to a plane
    reach:   real [1] = 4                           # in sigmas: beyond it a match hardly counts
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/icp.json.gz")
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
