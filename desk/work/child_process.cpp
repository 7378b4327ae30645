#include "desk/work/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

namespace tiltfeed::desk {
namespace {

/// What becomes of the child between fork and exec; nothing here allocates.
[[noreturn]] void become(char* const* words, int input, int out) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::signal(SIGPIPE, SIG_DFL);
  ::signal(SIGINT, SIG_DFL);
  ::setpgid(0, 0);  // Ctrl-C at the terminal is for us alone
  constexpr int kNotFound = 127;
  if (::dup2(input, STDIN_FILENO) < 0 || ::dup2(out, STDOUT_FILENO) < 0 || ::dup2(out, STDERR_FILENO) < 0)
    ::_exit(kNotFound);
  ::close_range(STDERR_FILENO + 1, ~0U, 0);
  ::execv(words[0], words);
  constexpr char kWhy[] = "the program cannot be started; it belongs beside tiltfeed-desk: install both\n";
  (void)!::write(STDERR_FILENO, kWhy, sizeof kWhy - 1);
  ::_exit(kNotFound);
}

}  // namespace

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& words) {
  const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (null < 0) return fail(Code::kIo, std::string("/dev/null: ") + std::strerror(errno));
  return start_with(words, null, -1);
}

Result<ChildProcess> ChildProcess::start_talk(const std::vector<std::string>& words) {
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    return fail(Code::kIo, std::string("pipe: ") + std::strerror(errno));
  ::fcntl(ends[1], F_SETFL, O_NONBLOCK);
  return start_with(words, ends[0], ends[1]);
}

Result<ChildProcess> ChildProcess::start_with(const std::vector<std::string>& words, int input, int say) {
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    const std::string why = std::strerror(errno);
    ::close(input);
    if (say >= 0) ::close(say);
    return fail(Code::kIo, "pipe: " + why);
  }
  std::vector<std::string> kept = words;
  std::vector<char*> arguments;
  for (std::string& word : kept) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int pid = ::fork();
  if (pid == 0) become(arguments.data(), input, ends[1]);
  const int failed = errno;
  ::close(ends[1]);
  ::close(input);
  if (pid < 0) {
    ::close(ends[0]);
    if (say >= 0) ::close(say);
    return fail(Code::kIo, words[0] + ": " + std::strerror(failed));
  }
  ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
  return ChildProcess(pid, ends[0], say);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      hear_(std::exchange(other.hear_, -1)),
      say_(std::exchange(other.say_, -1)),
      said_(std::move(other.said_)) {}

ChildProcess::~ChildProcess() {
  if (pid_ >= 0) ::kill(pid_, SIGKILL);
  end();
}

bool ChildProcess::listen() {
  std::array<char, 4096> block{};
  while (true) {
    const ssize_t count = ::read(hear_, block.data(), block.size());
    if (count == 0) return true;
    if (count < 0) {
      if (errno == EINTR) continue;
      return errno != EAGAIN;
    }
    said_.append(block.data(), static_cast<std::size_t>(count));
    if (said_.size() > kKept) said_.erase(0, said_.size() - kKept);
  }
}

bool ChildProcess::say(const std::string& line) {
  const std::string whole = line + "\n";
  ssize_t written = -1;
  do written = say_ < 0 ? -1 : ::write(say_, whole.data(), whole.size());
  while (say_ >= 0 && written < 0 && errno == EINTR);
  return written == static_cast<ssize_t>(whole.size());
}

std::vector<std::string> ChildProcess::take_lines() {
  std::vector<std::string> lines;
  for (std::size_t end = said_.find('\n'); end != std::string::npos; end = said_.find('\n')) {
    lines.push_back(said_.substr(0, end));
    said_.erase(0, end + 1);
  }
  return lines;
}

void ChildProcess::interrupt() {
  if (pid_ >= 0) ::kill(pid_, SIGINT);
}

ChildEnd ChildProcess::end() {
  ChildEnd ended;
  if (say_ >= 0) ::close(say_), say_ = -1;  // a program that is talked to ends when nothing more can come
  if (pid_ >= 0) {
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    ended.status = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  if (hear_ >= 0) ::close(hear_), hear_ = -1;
  ended.text = std::move(said_);
  return ended;
}

}  // namespace tiltfeed::desk
