# What a solve knows of one connected component of the problem.

# The trust region of a component, and the dogleg inside it; see dogleg.pyx.
ctypedef struct Region:
    double radius             # in scaled variables; 0: not chosen yet
    double regularisation     # multiple of the scale that is added to the diagonal
    bint known                # whether this linearisation has its Gauss-Newton step
    double newton_length      # squared, in scaled variables
    double descent_length     # the same of steepest descent
    double descent_curvature
    double descent_added
    double length             # of the proposed step, in scaled variables


ctypedef struct Component:
    int status                # RUNNING, or how it ended
    int verdict               # of the present attempt: RUNNING, or how it ends
    bint guarded              # whether a guard of an instance of it reads parameters
    bint fresh                # whether it has moved since its last linearisation, or has none
    bint tried                # whether it takes part in the present attempt
    bint factored             # whether the damped matrix of its last attempt was positive definite
    bint accepted             # whether its present step is
    Py_ssize_t attempts
    Py_ssize_t steps          # accepted attempts
    Py_ssize_t retry          # rejections before this attempt, with the same linearisation
    Py_ssize_t small_steps
    double start_cost
    double cost               # of the accepted state
    double before             # of the state that the last attempt began from
    double trial_cost         # NaN without a step
    double predicted          # reduction that the linear model predicts for the step
    double promise            # reduction that it predicts for the step without bounds and region
    double added              # of the promise, by what was added to the diagonal
    double step_length        # squared
    double damping            # lambda of the next attempt; of the dogleg its regularisation
    double damped             # lambda in effect
    double growth             # Nielsen's nu
    double norm               # of its parameters; only if an end asks for it
    double energy             # see `StatePair.energy`
    double noise_floor        # of its cost, by rounding
    double[3] jitter          # of the costs of the last rejected states
    bint proven               # whether an undamped step was asked for
    double gradient           # sum of g_i^2 / H_ii; at its end, or if an end asks for it
    double predicted_decrease  # by the last linearisation, least damped
    Region region
