/* Enough stack for a call: on the calling thread if it has that much left, else on a thread made for
 * the call. Python programs may give their threads stacks of 32 KiB; kernels of large constraints keep
 * their lanes on the stack, and compilers spill temporaries there.
 *
 * The caller must not hold the GIL if the call may ask for it.
 */

#include <stddef.h>

typedef void (*StackCall)(void *job);

#if (defined(__linux__) || defined(__APPLE__)) && defined(__GNUC__) && !defined(__EMSCRIPTEN__)
#include <pthread.h>
#include <signal.h>

#define STACK_SPARE (64 << 10) /* for what the call itself calls, libm and handlers included */

static __thread char *stack_end; /* lowest byte of this thread's stack, once it was asked for */

static char *stack_lowest(void) {
#if defined(__APPLE__)
    const pthread_t self = pthread_self();
    return (char *)pthread_get_stackaddr_np(self) - pthread_get_stacksize_np(self);
#else
    pthread_attr_t attributes;
    void *lowest = NULL;
    size_t size;
    if (pthread_getattr_np(pthread_self(), &attributes)) return NULL;
    if (pthread_attr_getstack(&attributes, &lowest, &size)) lowest = NULL;
    pthread_attr_destroy(&attributes);
    return (char *)lowest;
#endif
}

/* Whether `need` bytes are left; true where that is not known. */
static int stack_suffices(size_t need) {
    if (stack_end == NULL) {
        stack_end = stack_lowest();
        if (stack_end == NULL) stack_end = (char *)1;
    }
    return (size_t)((char *)__builtin_frame_address(0) - stack_end) > need;
}

typedef struct {
    StackCall call;
    void *job;
} StackWork;

static void *stack_run(void *given) {
    const StackWork *work = (const StackWork *)given;
    work->call(work->job);
    return NULL;
}

/* Make the call on a thread with `need` bytes and wait for it; 0 if there is no such thread. */
static int stack_elsewhere(size_t need, StackCall call, void *job) {
    StackWork work = {call, job};
    pthread_attr_t attributes;
    pthread_t thread;
    sigset_t all, before;
    int made;
    if (pthread_attr_init(&attributes)) return 0;
    need = (need + STACK_SPARE + 0xffff) & ~(size_t)0xffff;
    made = pthread_attr_setstacksize(&attributes, need) == 0;
    if (made) {
        /* Signals are for Python's threads. */
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &before);
        made = pthread_create(&thread, &attributes, stack_run, &work) == 0;
        pthread_sigmask(SIG_SETMASK, &before, NULL);
    }
    pthread_attr_destroy(&attributes);
    if (made) pthread_join(thread, NULL);
    return made;
}

#else

static int stack_suffices(size_t need) {
    (void)need;
    return 1;
}

static int stack_elsewhere(size_t need, StackCall call, void *job) {
    (void)need;
    call(job);
    return 1;
}

#endif
