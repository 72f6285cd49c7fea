# What a solve knows of one connected component of the problem.
#
# With many components each pass over them reads from memory, so that what every attempt reads and
# writes stands first, and what few do stands last.

from libc.stdint cimport int32_t, uint8_t


# The trust region of a component, and the dogleg inside it; see dogleg.pxi.
ctypedef struct Region:
    double radius             # in scaled variables; 0: not chosen yet
    double regularisation     # multiple of the scale that is added to the diagonal
    double newton_length      # squared, in scaled variables
    double length             # of the proposed step, in scaled variables
    double descent_length     # of steepest descent, squared, in scaled variables
    double descent_curvature
    double descent_added


ctypedef struct Component:
    int32_t status            # RUNNING, or how it ended
    int32_t verdict           # of the present attempt: RUNNING, or how it ends
    uint8_t tried             # whether it takes part in the present attempt
    uint8_t accepted          # whether its present step is
    uint8_t factored          # whether the damped matrix of its last attempt was positive definite
    uint8_t fresh             # whether it has moved since its last linearisation, or has none
    uint8_t known             # whether this linearisation has its Gauss-Newton step
    uint8_t guarded           # whether a guard of an instance of it reads parameters
    uint8_t bounded           # whether a scalar of it has a bound
    uint8_t proven            # whether an undamped step was asked for
    uint8_t whole             # whether region and bounds left the proposed step whole
    uint8_t secant            # whether the proposed step is a secant step
    uint8_t asked             # whether the last factor is asked for its end
    uint8_t paired            # whether the last step left a pair: see levenberg/secant.pxi
    double cost               # of the accepted state
    double before             # of the state that the last attempt began from
    double trial_cost         # NaN without a step
    double predicted          # reduction that the linear model predicts for the step
    double promise            # reduction that it predicts for the step without bounds and region
    double step_length        # squared
    double damping            # lambda of the next attempt; of the dogleg its regularisation
    double damped             # lambda in effect
    Region region
    double added              # of the promise, by what was added to the diagonal
    double energy             # see `StatePair.energy`
    double noise_floor        # of its cost, by rounding
    double predicted_decrease  # by the last linearisation, least damped
    int32_t retry             # rejections before this attempt, with the same linearisation
    int32_t small_steps
    Py_ssize_t attempts
    Py_ssize_t steps          # accepted attempts
    double start_cost
    double growth             # Nielsen's nu
    double promise_before     # of the linearisation that the pair is from
    double norm               # of its parameters; only if an end asks for it
    double[3] jitter          # of the costs of the last rejected states
    double gradient           # sum of g_i^2 / H_ii; at its end, or if an end asks for it
