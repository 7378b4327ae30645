#include "daemon/service/copy_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <system_error>
#include <thread>

namespace tiltfeed::daemon {

namespace {

enum class Why : int { kNone, kNoFile, kTooLarge, kChanges, kRead, kWrite };

/// What the child says: of which item, and errno.
struct Report {
  std::uint32_t item = 0;
  Why why = Why::kNone;
  int error = 0;
  std::uint64_t size = 0;
};

// ---- in the child: nothing but system calls, since other threads may have held any lock at the fork
// ---------

/// Of two looks at it: nobody has written to it between them.
bool unchanged(const struct stat& before, const struct stat& after) {
  return before.st_size == after.st_size && before.st_mtim.tv_sec == after.st_mtim.tv_sec &&
         before.st_mtim.tv_nsec == after.st_mtim.tv_nsec;
}

/// A file system tells the time of a change by the ticks of a clock, 10 ms apart at most: what is written
/// afterwards gets another time than what was written before `status` was taken.
void pass_its_tick(const struct stat& status) {
  constexpr std::int64_t kTick = 20'000'000, kSecond = 1'000'000'000;
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  const std::int64_t seconds = now.tv_sec - status.st_mtim.tv_sec;
  const bool recent =
      std::abs(seconds) <= 1 && std::abs(seconds * kSecond + now.tv_nsec - status.st_mtim.tv_nsec) <= kTick;
  const timespec tick{0, kTick};
  if (recent) ::nanosleep(&tick, nullptr);
}

Report copy(int folder, const char* name, int from, std::uint64_t limit) {
  struct stat status {};
  if (::fstat(from, &status) != 0 || !S_ISREG(status.st_mode)) return {0, Why::kNoFile, 0, 0};
  pass_its_tick(status);
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > limit) return {0, Why::kTooLarge, 0, size};
  // Operators are in the group; so is who shows them the program. The service's umask has the last word.
  // A name, no way to elsewhere, and nothing that somebody put there. Not openat2: the unit's
  // RestrictSUIDSGID refuses it.
  if (std::strchr(name, '/') != nullptr) return {0, Why::kWrite, EINVAL, 0};
  const int out = ::openat(folder, name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                           S_IRUSR | S_IWUSR | S_IRGRP);
  if (out < 0) return {0, Why::kWrite, errno, 0};
  static char bytes[CopyProcess::kMemory];
  std::uint64_t done = 0;
  for (;;) {
    const ssize_t count = ::pread(from, bytes, sizeof bytes, static_cast<off_t>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return {0, Why::kRead, errno, 0};
    if (count == 0) break;
    done += static_cast<std::uint64_t>(count);
    if (done > limit) return {0, Why::kChanges, 0, done};
    for (ssize_t at = 0; at < count;) {
      const ssize_t taken = ::write(out, bytes + at, static_cast<std::size_t>(count - at));
      if (taken < 0 && errno == EINTR) continue;
      if (taken <= 0) return {0, Why::kWrite, taken < 0 ? errno : ENOSPC, 0};
      at += taken;
    }
  }
  // A part of it as it was and a part as it is now would be a program that nobody wrote.
  struct stat now {};
  if (done != size || ::fstat(from, &now) != 0 || !unchanged(status, now)) return {0, Why::kChanges, 0, done};
  // The service syncs it again, which then takes no time.
  if (::fsync(out) != 0) return {0, Why::kWrite, errno, 0};
  return {};
}

/// Locks, sockets and wires of the service are not the child's to keep open.
void close_others(std::vector<int>& kept) {
  unsigned next = STDERR_FILENO + 1;
  for (const int fd : kept) {
    const auto number = static_cast<unsigned>(fd);
    if (number > next) ::syscall(SYS_close_range, next, number - 1, 0);
    next = std::max(next, number + 1);
  }
  ::syscall(SYS_close_range, next, ~0u, 0);
}

[[noreturn]] void run_child(int folder, const std::vector<CopyItem>& items, int report) {
  Report said;
  for (std::uint32_t i = 0; i < items.size() && said.why == Why::kNone; ++i) {
    said = copy(folder, items[i].name.c_str(), items[i].from, items[i].limit);
    said.item = i;
  }
  ::_exit(::write(report, &said, sizeof said) == sizeof said ? 0 : 1);
}

/// Where the kernel does not let go of a process, nobody waits for it but a thread of its own.
void end_process(pid_t pid) {
  ::kill(pid, SIGKILL);
  try {
    std::thread([pid] { ::waitpid(pid, nullptr, 0); }).detach();
  } catch (const std::system_error&) {
    ::waitpid(pid, nullptr, WNOHANG);
  }
}

}  // namespace

HandedFiles::~HandedFiles() {
  if (files_.empty()) return;
  const auto close_all = [files = files_] {
    for (const int file : files) ::close(file);
  };
  try {
    std::thread(close_all).detach();
  } catch (const std::system_error&) {
    close_all();  // no thread to be had
  }
}

Result<CopyProcess> CopyProcess::start(const std::string& folder, const std::vector<CopyItem>& items,
                                       std::chrono::milliseconds patience) {
  const auto failed = [&] {
    return fail(Code::kIo, folder + ": nothing can be copied: " + std::strerror(errno));
  };
  const int root = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (root < 0) return failed();
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) {
    ::close(root);
    return failed();
  }
  std::vector<int> kept{root, ends[1]};
  for (const CopyItem& item : items) kept.push_back(item.from);
  std::sort(kept.begin(), kept.end());
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    close_others(kept);
    run_child(root, items, ends[1]);
  }
  const int why = errno;
  ::close(root);
  ::close(ends[1]);
  if (pid > 0) return CopyProcess(pid, ends[0], items, patience);
  ::close(ends[0]);
  errno = why;
  return failed();
}

CopyProcess::CopyProcess(CopyProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      report_(std::exchange(other.report_, -1)),
      items_(std::move(other.items_)),
      patience_(other.patience_),
      began_(other.began_) {}

CopyProcess::~CopyProcess() {
  if (report_ >= 0) ::close(report_);
  if (pid_ >= 0) end_process(pid_);
}

std::optional<Result<void>> CopyProcess::check() {
  if (pid_ < 0) return std::nullopt;
  if (::waitpid(pid_, nullptr, WNOHANG) == pid_) {
    pid_ = -1;
    return outcome();
  }
  if (std::chrono::steady_clock::now() - began_ < patience_) return std::nullopt;
  end_process(std::exchange(pid_, -1));
  return fail(Code::kInput, items_.front().name + ": reading it takes longer than " +
                                std::to_string(patience_.count() / 1000) +
                                " s; copy it to a disk of this computer first");
}

Result<void> CopyProcess::outcome() const {
  Report said;
  if (::read(report_, &said, sizeof said) != sizeof said || said.item >= items_.size())
    return fail(Code::kIo, items_.front().name + ": the process that copies it has died; submit it again");
  const CopyItem& item = items_[said.item];
  switch (said.why) {
    case Why::kNone:
      return {};
    case Why::kNoFile:
      return fail(Code::kInput, item.name + ": what was handed over is not a regular file");
    case Why::kTooLarge:
      return fail(Code::kInput, item.name + ": " + std::to_string(said.size) + " bytes; at most " +
                                    std::to_string(item.limit) + " are taken");
    case Why::kChanges:
      return fail(Code::kInput, item.name + ": changes while it is read; submit it when it is whole");
    case Why::kRead:
      return fail(Code::kIo, item.name + ": cannot be read: " + std::strerror(said.error));
    case Why::kWrite:
      return fail(Code::kIo, item.name + ": cannot be written: " + std::strerror(said.error));
  }
  return {};
}

}  // namespace tiltfeed::daemon
