/* A small pool of threads: shares the items of a job between the caller and sleeping helpers.
 *
 * There is one pool per process, created on first use. If it is in use, by another thread or by a
 * caller in this one, a job runs all its items on its own thread, so jobs never wait for each other
 * and nested jobs cannot deadlock. Helpers never call Python. Items are assigned one at a time in
 * ascending order; the assignment to threads is not deterministic, so results must depend on the
 * items only.
 *
 * Between jobs a helper spins for a short time and then sleeps: the jobs of a solve follow each
 * other closely, and waking takes longer than the shortest of them.
 */

#include <stddef.h>

typedef void (*PoolTask)(void *job, ptrdiff_t item);

#define POOL_MOST 64

#if (defined(__unix__) || defined(__APPLE__)) && defined(__GNUC__) && !defined(__EMSCRIPTEN__)
#define POOL_THREADS 1

#include <pthread.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#define POOL_WATCH 50e-6        /* seconds that a thread spins before it sleeps */
#define POOL_STACK (8 << 20)    /* kernels keep arrays of lanes on the stack */

static struct {
    pthread_mutex_t lock;       /* protects all members that are not marked atomic */
    pthread_cond_t offered;     /* a job is available */
    pthread_cond_t left;        /* no helper works on the job */
    int taken;                  /* atomic: the pool is in use */
    unsigned number;            /* atomic: jobs so far */
    ptrdiff_t next;             /* atomic: next item to assign */
    int inside;                 /* atomic: helpers in the job */
    int watching;               /* atomic: whether helpers spin before sleeping */
    int open, wanted, entered;  /* whether the job accepts helpers, maximum, current number */
    int helpers, looking, asleep;
    int ready;                  /* whether the fork handler is installed */
    PoolTask task;
    void *job;
    ptrdiff_t items;
} pool = {PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, PTHREAD_COND_INITIALIZER};

static double pool_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void pool_breathe(void) {
    int i;
    for (i = 0; i < 16; i++) {
#if defined(__x86_64__) || defined(__i386__)
        __builtin_ia32_pause();
#elif defined(__aarch64__)
        __asm__ __volatile__("yield");
#endif
    }
}

static void pool_work(PoolTask task, void *job, ptrdiff_t items) {
    for (;;) {
        const ptrdiff_t item = __atomic_fetch_add(&pool.next, 1, __ATOMIC_RELAXED);
        if (item >= items) return;
        task(job, item);
    }
}

static void *pool_helper(void *unused) {
    unsigned seen = 0;
    (void)unused;
    pthread_mutex_lock(&pool.lock);
    for (;;) {
        if (pool.open && pool.number != seen && pool.entered < pool.wanted) {
            const PoolTask task = pool.task;
            void *const job = pool.job;
            const ptrdiff_t items = pool.items;
            seen = pool.number;
            pool.entered++;
            __atomic_fetch_add(&pool.inside, 1, __ATOMIC_RELAXED);
            pthread_mutex_unlock(&pool.lock);
            pool_work(task, job, items);
            pthread_mutex_lock(&pool.lock);
            if (__atomic_sub_fetch(&pool.inside, 1, __ATOMIC_RELEASE) == 0)
                pthread_cond_signal(&pool.left);
            continue;
        }
        seen = pool.number;
        if (__atomic_load_n(&pool.watching, __ATOMIC_RELAXED)) {
            const double until = pool_seconds() + POOL_WATCH;
            pool.looking++;
            pthread_mutex_unlock(&pool.lock);
            while (__atomic_load_n(&pool.number, __ATOMIC_RELAXED) == seen
                   && pool_seconds() < until)
                pool_breathe();
            pthread_mutex_lock(&pool.lock);
            pool.looking--;
        }
        if (pool.number == seen) {
            pool.asleep++;
            pthread_cond_wait(&pool.offered, &pool.lock);
            pool.asleep--;
        }
    }
    return NULL;
}

/* The child of a fork has no helpers, and the thread that held the lock does not exist there. */
static void pool_forked(void) {
    pthread_mutex_init(&pool.lock, NULL);
    pthread_cond_init(&pool.offered, NULL);
    pthread_cond_init(&pool.left, NULL);
    pool.taken = pool.inside = pool.open = 0;
    pool.helpers = pool.looking = pool.asleep = 0;
}

/* Start helpers up to `count`, or as many as the system allows; the lock is held. */
static void pool_hire(int count) {
    pthread_attr_t how;
    pthread_t helper;
    sigset_t all, before;
    if (!pool.ready) pool.ready = pthread_atfork(NULL, NULL, pool_forked) == 0;
    if (pool.helpers >= count || pthread_attr_init(&how)) return;
    pthread_attr_setdetachstate(&how, PTHREAD_CREATE_DETACHED);
    pthread_attr_setstacksize(&how, POOL_STACK);
    /* Signals are handled by Python's threads only. */
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    while (pool.helpers < count && pthread_create(&helper, &how, pool_helper, NULL) == 0)
        pool.helpers++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    pthread_attr_destroy(&how);
}

/* Offer a job; the lock is held. */
static void pool_offer(int helpers, PoolTask task, void *job, ptrdiff_t items) {
    int calls;
    pool.task = task;
    pool.job = job;
    pool.items = items;
    pool.wanted = helpers;
    pool.entered = 0;
    pool.open = 1;
    __atomic_store_n(&pool.next, 0, __ATOMIC_RELAXED);
    __atomic_store_n(&pool.number, pool.number + 1, __ATOMIC_RELAXED);
    calls = helpers - pool.looking < pool.asleep ? helpers - pool.looking : pool.asleep;
    for (; calls > 0; calls--) pthread_cond_signal(&pool.offered);
}

/* Wait until all helpers have left the job. */
static void pool_close(void) {
    const double until = pool_seconds() + POOL_WATCH;
    pthread_mutex_lock(&pool.lock);
    pool.open = 0;
    if (pool.watching) {
        pthread_mutex_unlock(&pool.lock);
        while (__atomic_load_n(&pool.inside, __ATOMIC_ACQUIRE) && pool_seconds() < until)
            pool_breathe();
        pthread_mutex_lock(&pool.lock);
    }
    while (pool.inside) pthread_cond_wait(&pool.left, &pool.lock);
    pthread_mutex_unlock(&pool.lock);
}

/* Run task(job, i) for all items i, on up to `threads` threads; returns when all are done. */
static void pool_share(int threads, ptrdiff_t items, PoolTask task, void *job) {
    ptrdiff_t item;
    int helpers;
    if (threads > items) threads = (int)items;
    if (threads > POOL_MOST) threads = POOL_MOST;
    if (threads <= 1 || __atomic_exchange_n(&pool.taken, 1, __ATOMIC_ACQUIRE)) {
        for (item = 0; item < items; item++) task(job, item);
        return;
    }
    helpers = threads - 1;
    pthread_mutex_lock(&pool.lock);
    pool_hire(helpers);
    __atomic_store_n(&pool.watching, threads <= sysconf(_SC_NPROCESSORS_ONLN), __ATOMIC_RELAXED);
    pool_offer(helpers, task, job, items);
    pthread_mutex_unlock(&pool.lock);
    pool_work(task, job, items);
    pool_close();
    __atomic_store_n(&pool.taken, 0, __ATOMIC_RELEASE);
}

/* Acquire a free workspace of `count`; a job never has more threads than workspaces. */
static int pool_claim(int *busy, int count) {
    int i;
    for (i = 0; __atomic_exchange_n(busy + i, 1, __ATOMIC_ACQUIRE); i = (i + 1) % count) {}
    return i;
}

static void pool_release(int *busy, int place) {
    __atomic_store_n(busy + place, 0, __ATOMIC_RELEASE);
}

static int pool_helpers(void) {
    int found;
    pthread_mutex_lock(&pool.lock);
    found = pool.helpers;
    pthread_mutex_unlock(&pool.lock);
    return found;
}

#else
#define POOL_THREADS 0

static void pool_share(int threads, ptrdiff_t items, PoolTask task, void *job) {
    ptrdiff_t item;
    (void)threads;
    for (item = 0; item < items; item++) task(job, item);
}

static int pool_claim(int *busy, int count) {
    (void)busy;
    (void)count;
    return 0;
}

static void pool_release(int *busy, int place) {
    (void)busy;
    (void)place;
}

static int pool_helpers(void) { return 0; }

#endif
