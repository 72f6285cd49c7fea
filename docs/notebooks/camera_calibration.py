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
# # Camera calibration
#
# Focal lengths, principal points and distortions of several cameras on a rig, and their mounting, from pictures of a flat target with known corners.
#
# The page [Camera calibration](../problems/camera_calibration.md) explains the model and the results; `examples/camera_calibration` makes the data.

# %% [markdown]
# The model, as the file `camera_calibration.arael` has it:

# %%
import arael

Model = arael.loads('''
# Calibration of a rig of cameras from pictures of a flat target with known corners.

# Radial and tangential distortion (Brown, Conrady): k1, k2, p1, p2.
fn brown_conrady(u, s, k) = u * (1 + s * (k[0] + s * k[1])) + [
    2 * k[2] * u.x * u.y + k[3] * (s + 2 * u.x^2),
    k[2] * (s + 2 * u.y^2) + 2 * k[3] * u.x * u.y]

# Angle in the picture of a fisheye lens, by the angle t from its axis (Kannala, Brandt): k1 to k4.
fn kannala_brandt(t, s, k) = t * (1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))))

struct Camera {
    name:        string
    fisheye:     bool = false
    param f:     vec2 [px]                            # focal lengths
    param c:     vec2 [px]                            # principal point
    param k:     vec<4>    = [0, 0, 0, 0]             # distortion, of the camera's kind
    param mount: transform = [0, 0, 0, 1, 0, 0, 0]    # rig to camera
    key name
}

struct View {
    param board: transform = [0, 0, 1, 1, 0, 0, 0]    # target to rig
}

struct Corner {
    camera: ref Camera in root.cameras
    view:   ref View in root.views
    on:     vec3 [m]                # on the target
    pixel:  vec2 [px]

    constraint narrow_lens when not camera.fisheye {
        let p = camera.mount * (view.board * on)
        let u = [p.x, p.y] / p.z
        (camera.f .* brown_conrady(u, dot(u, u), camera.k) + camera.c - pixel) / root.sigma
    }

    constraint fisheye_lens when camera.fisheye {
        let p = camera.mount * (view.board * on)
        let r = sqrt(p.x^2 + p.y^2 + 1e-18)     # not 0 on the axis
        let t = atan2(r, p.z)
        (camera.f .* [p.x, p.y] * (kannala_brandt(t, t^2, camera.k) / r) + camera.c - pixel) / root.sigma
    }
}

root Rig {
    cameras: list of Camera
    views:   list of View
    corners: list of Corner
    sigma:   real [px] = 0.2        # a corner is found to a fifth of a pixel
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/camera_calibration.json.gz")
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
