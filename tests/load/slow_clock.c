/* Makes the time that a program sees pass at another rate than the world's. Loaded before libc (LD_PRELOAD):
 *
 *   CLOCK_RATE    seconds that the program sees a true second; 0.1: every clock and every sleep ten times slower
 *   CLOCK_ORIGIN  the true time of day, in seconds, at which both times agree; the same for all processes of a run
 *
 * Clocks are read through it; what waits for a time or for a while waits as much longer in true time. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
#include <linux/futex.h>

typedef long long Nanoseconds;
enum { kSecond = 1000000000 };

static double rate = 1.0;
static Nanoseconds day_origin, steady_origin; /* true */

#define REAL(name) \
  static __typeof__(&name) real; \
  if (!real) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)

static Nanoseconds from_spec(const struct timespec *t) { return (Nanoseconds)t->tv_sec * kSecond + t->tv_nsec; }
static struct timespec to_spec(Nanoseconds n) {
  if (n < 0) n = 0;
  return (struct timespec){.tv_sec = (time_t)(n / kSecond), .tv_nsec = (long)(n % kSecond)};
}

static int true_time(clockid_t clock, struct timespec *out) { return (int)syscall(SYS_clock_gettime, clock, out); }

static int is_day(clockid_t clock) { return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE; }
static int is_processor(clockid_t clock) {
  return clock == CLOCK_PROCESS_CPUTIME_ID || clock == CLOCK_THREAD_CPUTIME_ID || clock < 0;
}
static Nanoseconds origin(clockid_t clock) { return is_day(clock) ? day_origin : steady_origin; }
static Nanoseconds shown(clockid_t clock, Nanoseconds t) {
  return origin(clock) + (Nanoseconds)((double)(t - origin(clock)) * rate);
}
static Nanoseconds true_at(clockid_t clock, Nanoseconds t) {
  return origin(clock) + (Nanoseconds)((double)(t - origin(clock)) / rate);
}
static struct timespec longer(const struct timespec *t) {
  return to_spec((Nanoseconds)((double)from_spec(t) / rate + 0.999));
}
static int longer_ms(int ms) { return ms <= 0 ? ms : (int)((double)ms / rate + 0.999); }

__attribute__((constructor)) static void begin(void) {
  const char *const wanted = getenv("CLOCK_RATE"), *const since = getenv("CLOCK_ORIGIN");
  if (!wanted || !since) return;
  struct timespec day, steady;
  true_time(CLOCK_REALTIME, &day);
  true_time(CLOCK_MONOTONIC, &steady);
  day_origin = (Nanoseconds)(strtod(since, NULL) * 1e6) * 1000;
  steady_origin = from_spec(&steady) - (from_spec(&day) - day_origin);
  rate = strtod(wanted, NULL);
}

int clock_gettime(clockid_t clock, struct timespec *out) {
  const int status = true_time(clock, out);
  if (status == 0 && !is_processor(clock)) *out = to_spec(shown(clock, from_spec(out)));
  return status;
}

int gettimeofday(struct timeval *out, void *zone) {
  (void)zone;
  struct timespec t;
  if (clock_gettime(CLOCK_REALTIME, &t)) return -1;
  *out = (struct timeval){.tv_sec = t.tv_sec, .tv_usec = t.tv_nsec / 1000};
  return 0;
}

time_t time(time_t *out) {
  struct timespec t;
  clock_gettime(CLOCK_REALTIME, &t);
  if (out) *out = t.tv_sec;
  return t.tv_sec;
}

int clock_nanosleep(clockid_t clock, int flags, const struct timespec *t, struct timespec *rest) {
  REAL(clock_nanosleep);
  const struct timespec wait = flags & TIMER_ABSTIME ? to_spec(true_at(clock, from_spec(t))) : longer(t);
  const int status = real(clock, flags, &wait, rest);
  if (status == EINTR && rest && !(flags & TIMER_ABSTIME)) *rest = to_spec((Nanoseconds)((double)from_spec(rest) * rate));
  return status;
}

int nanosleep(const struct timespec *t, struct timespec *rest) {
  const int status = clock_nanosleep(CLOCK_MONOTONIC, 0, t, rest);
  if (status == 0) return 0;
  errno = status;
  return -1;
}

int usleep(useconds_t us) {
  const struct timespec t = to_spec((Nanoseconds)us * 1000);
  return nanosleep(&t, NULL);
}

unsigned sleep(unsigned seconds) {
  struct timespec t = {.tv_sec = seconds}, rest = {0};
  return nanosleep(&t, &rest) ? (unsigned)rest.tv_sec : 0;
}

int poll(struct pollfd *fds, nfds_t count, int ms) {
  REAL(poll);
  return real(fds, count, longer_ms(ms));
}

int ppoll(struct pollfd *fds, nfds_t count, const struct timespec *t, const sigset_t *mask) {
  REAL(ppoll);
  struct timespec wait;
  if (t) wait = longer(t);
  return real(fds, count, t ? &wait : NULL, mask);
}

int select(int count, fd_set *r, fd_set *w, fd_set *e, struct timeval *t) {
  REAL(select);
  if (!t) return real(count, r, w, e, NULL);
  const struct timespec asked = {.tv_sec = t->tv_sec, .tv_nsec = t->tv_usec * 1000}, wait = longer(&asked);
  struct timeval limit = {.tv_sec = wait.tv_sec, .tv_usec = wait.tv_nsec / 1000};
  const int status = real(count, r, w, e, &limit);
  const struct timespec left =
      to_spec((Nanoseconds)((double)((Nanoseconds)limit.tv_sec * kSecond + limit.tv_usec * 1000LL) * rate));
  *t = (struct timeval){.tv_sec = left.tv_sec, .tv_usec = left.tv_nsec / 1000};
  return status;
}

int pselect(int count, fd_set *r, fd_set *w, fd_set *e, const struct timespec *t, const sigset_t *mask) {
  REAL(pselect);
  struct timespec wait;
  if (t) wait = longer(t);
  return real(count, r, w, e, t ? &wait : NULL, mask);
}

int epoll_wait(int fd, struct epoll_event *events, int count, int ms) {
  REAL(epoll_wait);
  return real(fd, events, count, longer_ms(ms));
}

int epoll_pwait(int fd, struct epoll_event *events, int count, int ms, const sigset_t *mask) {
  REAL(epoll_pwait);
  return real(fd, events, count, longer_ms(ms), mask);
}

int pthread_cond_clockwait(pthread_cond_t *c, pthread_mutex_t *m, clockid_t clock, const struct timespec *t) {
  REAL(pthread_cond_clockwait);
  const struct timespec until = to_spec(true_at(clock, from_spec(t)));
  return real(c, m, clock, &until);
}

/* With the condition's own clock, which cannot be asked: the clock whose time is nearer. */
static clockid_t clock_of(const struct timespec *t) {
  struct timespec steady;
  true_time(CLOCK_MONOTONIC, &steady);
  return t->tv_sec > 2 * steady.tv_sec + 100000000 ? CLOCK_REALTIME : CLOCK_MONOTONIC;
}

int pthread_cond_timedwait(pthread_cond_t *c, pthread_mutex_t *m, const struct timespec *t) {
  REAL(pthread_cond_timedwait);
  const struct timespec until = to_spec(true_at(clock_of(t), from_spec(t)));
  return real(c, m, &until);
}

int sem_timedwait(sem_t *s, const struct timespec *t) {
  REAL(sem_timedwait);
  const struct timespec until = to_spec(true_at(CLOCK_REALTIME, from_spec(t)));
  return real(s, &until);
}

int sem_clockwait(sem_t *s, clockid_t clock, const struct timespec *t) {
  REAL(sem_clockwait);
  const struct timespec until = to_spec(true_at(clock, from_spec(t)));
  return real(s, clock, &until);
}

int sigtimedwait(const sigset_t *set, siginfo_t *info, const struct timespec *t) {
  REAL(sigtimedwait);
  const struct timespec wait = longer(t);
  return real(set, info, &wait);
}

static struct timeval longer_value(struct timeval t) {
  const struct timespec asked = {.tv_sec = t.tv_sec, .tv_nsec = t.tv_usec * 1000}, wait = longer(&asked);
  return (struct timeval){.tv_sec = wait.tv_sec, .tv_usec = wait.tv_nsec / 1000};
}

int setsockopt(int fd, int level, int option, const void *value, socklen_t size) {
  REAL(setsockopt);
  if (level != SOL_SOCKET || (option != SO_RCVTIMEO && option != SO_SNDTIMEO) || size != sizeof(struct timeval))
    return real(fd, level, option, value, size);
  const struct timeval wait = longer_value(*(const struct timeval *)value);
  return real(fd, level, option, &wait, size);
}

int setitimer(__itimer_which_t which, const struct itimerval *t, struct itimerval *old) {
  REAL(setitimer);
  if (which != ITIMER_REAL || !t) return real(which, t, old);
  const struct itimerval wait = {longer_value(t->it_interval), longer_value(t->it_value)};
  return real(which, &wait, old);
}

unsigned alarm(unsigned seconds) {
  REAL(alarm);
  return real((unsigned)((double)seconds / rate + 0.999));
}

int timer_settime(timer_t timer, int flags, const struct itimerspec *t, struct itimerspec *old) {
  REAL(timer_settime);
  if (flags & TIMER_ABSTIME) return real(timer, flags, t, old);
  const struct itimerspec wait = {longer(&t->it_interval), longer(&t->it_value)};
  return real(timer, flags, &wait, old);
}

/* What libstdc++ and others wait by: the futex itself. */
long syscall(long number, ...) {
  static long (*real)(long, ...);
  if (!real) real = (long (*)(long, ...))dlsym(RTLD_NEXT, "syscall");
  va_list list;
  va_start(list, number);
  long a[6];
  for (int i = 0; i < 6; ++i) a[i] = va_arg(list, long);
  va_end(list);
  struct timespec wait;
  const int command = (int)a[1] & FUTEX_CMD_MASK;
  if (number == SYS_futex && a[3] && (command == FUTEX_WAIT || command == FUTEX_WAIT_BITSET)) {
    const struct timespec *const t = (const struct timespec *)a[3];
    const clockid_t clock = a[1] & FUTEX_CLOCK_REALTIME ? CLOCK_REALTIME : CLOCK_MONOTONIC;
    wait = command == FUTEX_WAIT ? longer(t) : to_spec(true_at(clock, from_spec(t)));
    a[3] = (long)&wait;
  }
  return real(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}
