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
# # Inertial measurements
#
# An inertial sensor measures hundreds of times a second. Preintegration (Forster, Carlone, Dellaert, Scaramuzza, *On-Manifold Preintegration*, 2017) replaces all samples between two states by one relative motion, with its covariance and its derivatives by the biases, so that nothing is integrated again while the solver moves.
#
# The page [Inertial measurements](../problems/imu_preintegration.md) explains the model and the results; `examples/imu_preintegration` makes the data.

# %% [markdown]
# The model, as the file `visual_inertial.arael` has it:

# %%
import arael

Model = arael.loads('''
# One camera and inertial measurements. The poses of the camera have a scale of their own and a frame
# that does not know which way is down; both are found with velocities and biases.

# Preintegrated inertial measurements (Forster et al. 2017), for models that import this file. They
# declare in their root: `states: list of State`, `down: direction` (a parameter or data),
# `gravity: real [m/s^2]`, `gyro_walk` and `accel_walk` (densities of the biases' random walks).
# `arael.geometry.preintegrate` makes the columns of `Imu`.

# Position, attitude (body to world), velocity and biases at one time.
component Nav {
    param pos:        vec3 [m]
    param q:          quaternion
    param vel:        vec3 [m/s] = [0, 0, 0]
    param gyro_bias:  vec3 [rad/s] = [0, 0, 0]
    param accel_bias: vec3 [m/s^2] = [0, 0, 0]
}

struct State {
    param nav: Nav
}

# All samples between two states as one relative motion, in the body frame of the first.
struct Imu {
    a: ref State in root.states
    b: ref State in root.states

    duration:   real [s]
    rotation:   quat
    velocity:   vec3
    position:   vec3
    gyro_bias:  vec3                     # where the samples were integrated
    accel_bias: vec3
    rotation_by_gyro:  mat3
    velocity_by_gyro:  mat3
    velocity_by_accel: mat3
    position_by_gyro:  mat3
    position_by_accel: mat3
    whiten: mat<9,9>

    # The integral changes with the biases to first order, so that samples are integrated once.
    constraint motion {
        let dg   = a.nav.gyro_bias - gyro_bias
        let da   = a.nav.accel_bias - accel_bias
        let t    = duration
        let g    = root.gravity * root.down
        let back = a.nav.q.conj()
        let turn = (rotation * exp(rotation_by_gyro * dg)).conj() * back * b.nav.q
        let dv   = back.rotate(b.nav.vel - a.nav.vel - g * t)
        let dp   = back.rotate(b.nav.pos - a.nav.pos - a.nav.vel * t - g * t^2 / 2)
        let ev   = dv - velocity - velocity_by_gyro * dg - velocity_by_accel * da
        let ep   = dp - position - position_by_gyro * dg - position_by_accel * da
        whiten * [turn.log(), ev, ep]
    }

    constraint walk {
        [(b.nav.gyro_bias - a.nav.gyro_bias) / (root.gyro_walk * sqrt(duration)),
         (b.nav.accel_bias - a.nav.accel_bias) / (root.accel_walk * sqrt(duration))]
    }
}

# A pose by the camera alone: position in units of the camera, attitude.
struct Sight {
    state: ref State in root.states
    pos:   vec3
    q:     quat

    constraint sight {
        [(root.scale * state.nav.pos - pos) / root.pos_sigma,
         (q.conj() * state.nav.q).log() / root.q_sigma]
    }
}

root VisualInertial {
    param scale: real = 1                # units of the camera in a metre
    param down:  direction
    states: list of State
    imu:    list of Imu
    sights: list of Sight

    gravity:    real = 9.81
    gyro_walk:  real = 1e-4
    accel_walk: real = 1e-3
    pos_sigma:  real = 0.002
    q_sigma:    real = 0.002
}
''')

# %% [markdown]
# The data, a file beside this notebook:

# %%
model = Model()
arael.read(model, "data/imu_preintegration.npz")
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
