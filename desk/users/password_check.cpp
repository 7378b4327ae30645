#include "desk/users/password_check.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>

#include "desk/users/password_hash.h"

namespace tiltfeed::desk {
namespace {

constexpr char kYes = 'y', kNo = 'n';

/// No other thread of the desk has a lock that is needed here but the allocator's, which a fork sets free.
[[noreturn]] void hash_in_child(const std::string& password, const std::string& hash, int out) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::dup2(out, STDOUT_FILENO) < 0) ::_exit(1);
  ::close_range(STDERR_FILENO + 1, ~0U, 0);
  const char answer = password_matches(password, hash) ? kYes : kNo;
  ::_exit(::write(STDOUT_FILENO, &answer, 1) == 1 ? 0 : 1);
}

}  // namespace

PasswordCheck::~PasswordCheck() {
  if (pid_ >= 0) ::kill(pid_, SIGKILL), ::waitpid(pid_, nullptr, 0);
  if (hear_ >= 0) ::close(hear_);
}

bool PasswordCheck::ask(const std::string& password, const std::string& hash, bool known, Checked checked,
                        Time now) {
  while (!failures_.empty() && now - failures_.front() >= kPeriod) failures_.pop_front();
  if (failures_.size() >= kFailures || asked_.size() >= kWaiting) return false;
  asked_.push_back({password, hash, known, std::move(checked)});
  if (asked_.size() > 1 || begin_next()) return true;
  asked_.clear();
  return false;
}

bool PasswordCheck::begin_next() {
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return false;
  const Asked& first = asked_.front();
  pid_ = ::fork();
  if (pid_ == 0) hash_in_child(first.password, first.hash, ends[1]);
  ::close(ends[1]);  // where there is no child, this end is a no
  hear_ = ends[0];
  return true;
}

void PasswordCheck::hear(Time now) {
  char answer = kNo;
  ssize_t got = -1;
  do got = ::read(hear_, &answer, 1);
  while (got < 0 && errno == EINTR);
  ::close(hear_);
  hear_ = -1;
  if (pid_ >= 0)
    while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
    }
  pid_ = -1;
  const Asked asked = std::move(asked_.front());
  asked_.pop_front();
  const bool good = got == 1 && answer == kYes && asked.known;
  if (!good) failures_.push_back(now);
  std::deque<Asked> dropped;
  if (!asked_.empty() && !begin_next()) dropped.swap(asked_);
  asked.checked(good);
  for (const Asked& one : dropped) one.checked(false);
}

}  // namespace tiltfeed::desk
