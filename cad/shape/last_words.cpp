#include "cad/shape/last_words.h"

#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>
#include <fstream>
#include <string_view>

namespace tiltfeed::cad {
namespace {

constexpr std::size_t kMostSaid = 400;
// The handler reads these; they are plain memory.
std::array<char, kMostSaid> said{};
const char* (*latest_of)() = nullptr;
volatile sig_atomic_t faults = 0;
// A stack overflow leaves the handler no other.
alignas(16) std::array<char, 64 * 1024> spare_stack{};

void say(std::string_view text) {
  const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
  static_cast<void>(written);
}

void end_by(int signal) {
  // The first time the exact place is asked for, which may fault once more.
  faults = faults + 1;
  if (faults == 1) {
    say(signal == SIGXCPU ? "took too much processor time while " : "failed inside OpenCASCADE while ");
    say(said.data());
    if (const char* last = latest_of == nullptr ? nullptr : latest_of()) {
      say(", after ");
      say(last);
    }
  }
  say("\n");
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

}  // namespace

void now_at(const std::string& what) {
  const std::size_t size = std::min(what.size(), kMostSaid - 1);
  std::memcpy(said.data(), what.data(), size);
  said[size] = '\0';
}

std::string at_now() { return said.data(); }

void ask_in_fault(const char* (*latest)()) { latest_of = latest; }

void hear_faults() {
  const stack_t stack{spare_stack.data(), 0, spare_stack.size()};
  ::sigaltstack(&stack, nullptr);
  struct sigaction action {};
  action.sa_handler = end_by;
  action.sa_flags = SA_ONSTACK | SA_NODEFER;
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU})
    ::sigaction(signal, &action, nullptr);
}

void limit_resources(int memory_mb, int seconds) {
  const auto limit = [](auto which, rlim_t most, rlim_t hard) {
    const rlimit value{most, hard};
    ::setrlimit(which, &value);
  };
  if (memory_mb > 0)
    limit(RLIMIT_AS, static_cast<rlim_t>(memory_mb) << 20, static_cast<rlim_t>(memory_mb) << 20);
  if (seconds > 0) limit(RLIMIT_CPU, static_cast<rlim_t>(seconds), static_cast<rlim_t>(seconds) + 5);
  limit(RLIMIT_CORE, 0, 0);
  // Where several share a limit of memory, this program is the first to go.
  std::ofstream("/proc/self/oom_score_adj") << 1000;
}

}  // namespace tiltfeed::cad
