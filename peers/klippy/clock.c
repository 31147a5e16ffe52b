/* Lets a host program live in the time of boards that run on this computer, by one page that all of them share.
 *
 * Loaded before the host's other libraries (LD_PRELOAD). Its monotonic clocks read the page; where it waits for bytes or for
 * time, it waits in the page's time, and says so in the page: for a board goes on only while everything that counts time waits and no
 * byte is on its way. virtual-prime/src/commands/clock_file.rs is the other side.
 *
 * VELVET_CLOCK      path of the page
 * VELVET_CLOCK_TTYS terminals of the boards, in the order of their numbers, with commas between them
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define BOARDS 4
#define THREADS 64
/* What the boards call zero is this for the host, to whom a clock near zero is strange. */
#define BASE_NS 100000000000ull
#define NEVER UINT64_MAX
/* A thread that counts time and works. */
#define WORKS 1
#define LEAST_NAP_NS 50000
#define MOST_NAP_NS 1000000

struct board {
    /* Twice, so that a reader notices when it has read half of a change. Zero twice: no such board. */
    _Atomic uint64_t now, again;
    /* Bytes that the host has written to the board's line, and read from it. */
    _Atomic uint64_t written, read;
};

struct page {
    struct board boards[BOARDS];
    /* Goes up whenever a thread begins or ends to wait. */
    _Atomic uint64_t turns;
    /* Bytes in the host's own pipes, by which its threads wake each other. */
    _Atomic uint64_t piped;
    /* For each thread that counts time, until when it waits; 0: no thread. */
    _Atomic uint64_t threads[THREADS];
};

static struct page *page;
static dev_t ttys[BOARDS];
static pthread_key_t leaving;
static __thread _Atomic uint64_t *entry;

static int (*next_clock)(clockid_t, struct timespec *);
static int (*next_ppoll)(struct pollfd *, nfds_t, const struct timespec *, const sigset_t *);
static ssize_t (*next_read)(int, void *, size_t);
static ssize_t (*next_write)(int, const void *, size_t);
static int (*next_cond)(pthread_cond_t *, pthread_mutex_t *, const struct timespec *);
static int (*next_sem)(sem_t *, clockid_t, const struct timespec *);

static void leave(void *mine)
{
    atomic_store((_Atomic uint64_t *)mine, 0);
    atomic_fetch_add(&page->turns, 1);
}

static void find_ttys(char *list)
{
    for (int i = 0; list && i < BOARDS; i++) {
        struct stat about;
        char *path = strsep(&list, ",");
        if (!stat(path, &about))
            ttys[i] = about.st_rdev;
    }
}

__attribute__((constructor)) static void begin(void)
{
    next_clock = dlsym(RTLD_NEXT, "clock_gettime");
    next_ppoll = dlsym(RTLD_NEXT, "ppoll");
    next_read = dlsym(RTLD_NEXT, "read");
    next_write = dlsym(RTLD_NEXT, "write");
    next_cond = dlsym(RTLD_NEXT, "pthread_cond_timedwait");
    next_sem = dlsym(RTLD_NEXT, "sem_clockwait");
    const char *path = getenv("VELVET_CLOCK");
    int file = path ? open(path, O_RDWR) : -1;
    if (file < 0)
        return;
    struct page *found = mmap(NULL, sizeof *found, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (found == MAP_FAILED)
        return;
    for (int i = 0; i < THREADS; i++)
        atomic_store(&found->threads[i], 0);
    atomic_store(&found->piped, 0);
    char *list = getenv("VELVET_CLOCK_TTYS");
    find_ttys(list ? strdup(list) : NULL);
    pthread_key_create(&leaving, leave);
    page = found;
    /* Programs that the host starts have the computer's time. */
    unsetenv("LD_PRELOAD");
}

__attribute__((destructor)) static void end(void)
{
    for (int i = 0; page && i < THREADS; i++)
        atomic_store(&page->threads[i], 0);
}

static uint64_t board_now(struct board *board)
{
    for (;;) {
        uint64_t now = atomic_load(&board->now), again = atomic_load(&board->again);
        if (now == again)
            return now;
    }
}

/* The time of the board that is furthest behind. */
static uint64_t now_ns(void)
{
    uint64_t least = NEVER;
    for (int i = 0; i < BOARDS; i++) {
        uint64_t now = board_now(&page->boards[i]);
        if (now && now < least)
            least = now;
    }
    return BASE_NS + (least == NEVER ? 0 : least);
}

static struct timespec of_ns(uint64_t ns)
{
    return (struct timespec){ns / 1000000000, ns % 1000000000};
}

static uint64_t to_ns(const struct timespec *time)
{
    return time->tv_sec * 1000000000ull + time->tv_nsec;
}

static int is_ours(clockid_t clock)
{
    return page && (clock == CLOCK_MONOTONIC || clock == CLOCK_MONOTONIC_RAW || clock == CLOCK_MONOTONIC_COARSE
                    || clock == CLOCK_BOOTTIME);
}

int clock_gettime(clockid_t clock, struct timespec *time)
{
    if (!is_ours(clock))
        return next_clock(clock, time);
    *time = of_ns(now_ns());
    return 0;
}

static void set_entry(uint64_t until)
{
    for (int i = 0; !entry && i < THREADS; i++) {
        uint64_t none = 0;
        if (atomic_compare_exchange_strong(&page->threads[i], &none, WORKS)) {
            entry = &page->threads[i];
            pthread_setspecific(leaving, (void *)entry);
        }
    }
    if (entry)
        atomic_store(entry, until);
    atomic_fetch_add(&page->turns, 1);
}

/* Waits for files, or until an instant of the page's time. */
static int wait_until(struct pollfd *files, nfds_t count, uint64_t until)
{
    int ready;
    set_entry(until);
    for (;;) {
        uint64_t now = now_ns();
        uint64_t nap = until > now ? (until - now) / 8 : 0;
        nap = nap < LEAST_NAP_NS ? LEAST_NAP_NS : nap > MOST_NAP_NS ? MOST_NAP_NS : nap;
        struct timespec limit = of_ns(now >= until ? 0 : nap);
        ready = next_ppoll(files, count, &limit, NULL);
        if (ready || now >= until)
            break;
    }
    int error = errno;
    set_entry(WORKS);
    errno = error;
    return ready;
}

int ppoll(struct pollfd *files, nfds_t count, const struct timespec *limit, const sigset_t *signals)
{
    if (!page || signals || (limit && !to_ns(limit)))
        return next_ppoll(files, count, limit, signals);
    return wait_until(files, count, limit ? now_ns() + to_ns(limit) : NEVER);
}

int poll(struct pollfd *files, nfds_t count, int limit_ms)
{
    struct timespec limit = of_ns(limit_ms > 0 ? limit_ms * 1000000ull : 0);
    return ppoll(files, count, limit_ms < 0 ? NULL : &limit, NULL);
}

int select(int count, fd_set *readable, fd_set *writable, fd_set *odd, struct timeval *limit)
{
    struct pollfd files[FD_SETSIZE];
    int used = 0, ready = 0;
    for (int fd = 0; fd < count; fd++) {
        short events = (readable && FD_ISSET(fd, readable) ? POLLIN : 0) | (writable && FD_ISSET(fd, writable) ? POLLOUT : 0)
                       | (odd && FD_ISSET(fd, odd) ? POLLPRI : 0);
        if (events)
            files[used++] = (struct pollfd){fd, events, 0};
    }
    int ms = limit ? limit->tv_sec * 1000 + (limit->tv_usec + 999) / 1000 : -1;
    if (poll(files, used, ms) < 0)
        return -1;
    fd_set *sets[] = {readable, writable, odd};
    const short wanted[] = {POLLIN | POLLHUP | POLLERR, POLLOUT | POLLERR, POLLPRI};
    for (int i = 0; i < 3; i++)
        for (int k = 0; sets[i] && k < used; k++) {
            int is_set = FD_ISSET(files[k].fd, sets[i]) && files[k].revents & wanted[i];
            if (!is_set)
                FD_CLR(files[k].fd, sets[i]);
            ready += is_set;
        }
    return ready;
}

int clock_nanosleep(clockid_t clock, int flags, const struct timespec *time, struct timespec *left)
{
    uint64_t ns = to_ns(time);
    if (!page || (flags & TIMER_ABSTIME && !is_ours(clock))) {
        int (*next)(clockid_t, int, const struct timespec *, struct timespec *) = dlsym(RTLD_NEXT, "clock_nanosleep");
        return next(clock, flags, time, left);
    }
    return wait_until(NULL, 0, flags & TIMER_ABSTIME ? ns : now_ns() + ns) < 0 ? errno : 0;
}

int nanosleep(const struct timespec *time, struct timespec *left)
{
    int error = clock_nanosleep(CLOCK_MONOTONIC, 0, time, left);
    errno = error;
    return error ? -1 : 0;
}

int usleep(useconds_t us)
{
    struct timespec time = of_ns(us * 1000ull);
    return nanosleep(&time, NULL);
}

/* An instant of the page's time by the computer's clock, as if both went on alike. What waits so, for a lock above all, counts no time. */
static struct timespec here(const struct timespec *until)
{
    struct timespec real;
    next_clock(CLOCK_MONOTONIC, &real);
    uint64_t at = to_ns(until), now = now_ns();
    return of_ns(to_ns(&real) + (at > now ? at - now : 0));
}

int pthread_cond_timedwait(pthread_cond_t *condition, pthread_mutex_t *mutex, const struct timespec *until)
{
    struct timespec real;
    next_clock(CLOCK_REALTIME, &real);
    /* A condition with the computer's date has an instant near that. */
    if (!page || until->tv_sec > real.tv_sec / 2)
        return next_cond(condition, mutex, until);
    struct timespec at = here(until);
    return next_cond(condition, mutex, &at);
}

int sem_clockwait(sem_t *semaphore, clockid_t clock, const struct timespec *until)
{
    if (!is_ours(clock))
        return next_sem(semaphore, clock, until);
    struct timespec at = here(until);
    return next_sem(semaphore, clock, &at);
}

/* Where bytes to or from this file are counted; `read` is whether they come from it. */
static _Atomic uint64_t *count_of(int file, int is_read)
{
    struct stat about;
    if (!page || fstat(file, &about))
        return NULL;
    if (S_ISFIFO(about.st_mode) && file > STDERR_FILENO)
        return &page->piped;
    for (int i = 0; S_ISCHR(about.st_mode) && i < BOARDS; i++)
        if (ttys[i] && ttys[i] == about.st_rdev)
            return is_read ? &page->boards[i].read : &page->boards[i].written;
    return NULL;
}

ssize_t read(int file, void *data, size_t size)
{
    ssize_t done = next_read(file, data, size);
    _Atomic uint64_t *count = done > 0 ? count_of(file, 1) : NULL;
    if (count == &page->piped)
        atomic_fetch_sub(count, done);
    else if (count)
        atomic_fetch_add(count, done);
    return done;
}

ssize_t write(int file, const void *data, size_t size)
{
    _Atomic uint64_t *count = count_of(file, 0);
    /* Counted before, so that the bytes are on their way at any time. */
    if (count)
        atomic_fetch_add(count, size);
    ssize_t done = next_write(file, data, size);
    if (count && done != (ssize_t)size)
        atomic_fetch_sub(count, size - (done > 0 ? done : 0));
    return done;
}
