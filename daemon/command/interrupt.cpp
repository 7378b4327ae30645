#include "daemon/command/interrupt.h"

#include <semaphore.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <string>
#include <thread>

#include "config/output_file.h"

namespace tiltfeed::daemon {

namespace {

constexpr int kStatus = 1;

std::atomic<bool> interrupt_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");

/// Handlers may post to a semaphore; hardly anything else wakes a thread from there.
struct Bell {
  sem_t rung{}, over{};
  Bell() { ::sem_init(&rung, 0, 0), ::sem_init(&over, 0, 0); }
};
Bell& bell() {
  static Bell the_bell;
  return the_bell;
}

extern "C" void take_interrupt(int) {
  const int kept = errno;
  interrupt_asked = true;
  ::sem_post(&bell().rung);
  errno = kept;
}

void wait_for(sem_t& semaphore) {
  while (::sem_wait(&semaphore) != 0 && errno == EINTR) {
  }
}

/// False when the time is over first.
bool wait_for(sem_t& semaphore, long milliseconds) {
  timespec until{};
  ::clock_gettime(CLOCK_MONOTONIC, &until);
  until.tv_nsec += milliseconds * 1'000'000;
  until.tv_sec += until.tv_nsec / 1'000'000'000, until.tv_nsec %= 1'000'000'000;
  int status = 0;
  while ((status = ::sem_clockwait(&semaphore, CLOCK_MONOTONIC, &until)) != 0 && errno == EINTR) {
  }
  return status == 0;
}

std::thread& watcher() {
  static std::thread thread;
  return thread;
}

[[noreturn]] void end_now() {
  const std::string written = config::OutputFile::abandon();
  const std::string word =
      std::string(::isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "") + "tiltfeed: cancelled; " +
      (written.empty() ? "nothing was written" : "only " + written + " was written") + "\n";
  if (::write(STDERR_FILENO, word.data(), word.size()) < 0) ::_exit(kStatus);
  ::_exit(kStatus);
}

}  // namespace

void hear_interrupts() {
  bell();
  std::signal(SIGINT, take_interrupt);
  std::signal(SIGTERM, take_interrupt);
}

bool interrupted() { return interrupt_asked; }

PromptEnd::PromptEnd() {
  watcher() = std::thread([] {
    wait_for(bell().rung);
    // Rung by the destructor, too: then it is over already.
    if (!wait_for(bell().over, kGraceMs)) end_now();
  });
}

PromptEnd::~PromptEnd() {
  ::sem_post(&bell().over);
  ::sem_post(&bell().rung);
  watcher().join();
}

}  // namespace tiltfeed::daemon
