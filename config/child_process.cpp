#include "config/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <utility>

namespace tiltfeed::config {
namespace {

// What is handed over lies above, so that nothing is overwritten on the way.
constexpr int kFirstOwn = 10;
constexpr int kLookForWord = 100;  // ms between looks at whether the user wants it to end
constexpr std::string_view kProgress = "progress ";

/// A pipe whose ends lie above what the process that is started has.
bool open_pipe(std::array<int, 2>& ends) {
  std::array<int, 2> low{};
  if (::pipe2(low.data(), O_CLOEXEC) != 0) return false;
  for (std::size_t i = 0; i < 2; ++i) {
    ends[i] = ::fcntl(low[i], F_DUPFD_CLOEXEC, kFirstOwn);
    ::close(low[i]);
  }
  return ends[0] >= 0 && ends[1] >= 0;
}

void close_all(std::initializer_list<int> descriptors) {
  for (const int fd : descriptors)
    if (fd >= 0) ::close(fd);
}

}  // namespace

ChildProcess::ChildProcess(ChildProcess&& other) noexcept : pid_(std::exchange(other.pid_, -1)) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  if (this == &other) return *this;
  end();
  pid_ = std::exchange(other.pid_, -1);
  return *this;
}

int ChildProcess::start(const std::vector<std::string>& words, std::initializer_list<HandedFile> files,
                        const std::string& folder) {
  assert(!runs());
  const int failed = spawn_program(pid_, words, files, folder);
  if (failed != 0) pid_ = -1;
  return failed;
}

std::optional<int> ChildProcess::ended() {
  int status = 0;
  if (pid_ < 0 || ::waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
  pid_ = -1;
  return status;
}

int ChildProcess::wait() {
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return status;
}

void ChildProcess::end() {
  if (pid_ < 0) return;
  ::kill(pid_, SIGKILL);
  wait();
}

HeardProcess::HeardProcess(HeardProcess&& other) noexcept
    : child_(std::move(other.child_)),
      tell_(std::exchange(other.tell_, -1)),
      hear_(std::exchange(other.hear_, -1)) {}

HeardProcess::~HeardProcess() { close_all({tell_, hear_}); }

int HeardProcess::start(const std::vector<std::string>& words, int file, bool told) {
  std::array<int, 2> in{-1, -1}, out{-1, -1};
  const int text = ::fcntl(file, F_DUPFD_CLOEXEC, kFirstOwn);
  int failed = text < 0 || !open_pipe(out) || (told && !open_pipe(in)) ? errno : 0;
  if (failed == 0 && told)
    failed = child_.start(
        words, {{in[0], STDIN_FILENO}, {out[1], STDOUT_FILENO}, {out[1], STDERR_FILENO}, {text, kFile}});
  else if (failed == 0)
    failed = child_.start(words, {{out[1], STDOUT_FILENO}, {out[1], STDERR_FILENO}, {text, kFile}});
  close_all({in[0], out[1], text});
  if (failed != 0) close_all({in[1], out[0]});
  if (failed == 0) tell_ = in[1], hear_ = out[0];
  return failed;
}

void HeardProcess::tell(std::string_view line) const {
  const ssize_t told = ::write(tell_, line.data(), line.size());
  static_cast<void>(told);
}

Result<void> HeardProcess::listen(const std::function<bool(double)>& progress,
                                  const std::function<void(const std::string&)>& take) {
  std::string rest;
  double share = 0.0;
  const auto take_line = [&](const std::string& line) {
    if (line.starts_with(kProgress))
      share = std::strtod(line.c_str() + kProgress.size(), nullptr);
    else
      take(line);
  };
  while (true) {
    pollfd look{hear_, POLLIN, 0};
    const int ready = ::poll(&look, 1, kLookForWord);
    if (progress && !progress(share)) return fail(Code::kCancelled, "cancelled; nothing was written");
    if (ready <= 0) continue;
    std::array<char, 65536> bytes;
    const ssize_t count = ::read(hear_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    rest.append(bytes.data(), static_cast<std::size_t>(count));
    std::size_t from = 0;
    for (auto end = rest.find('\n'); end != rest.npos; from = end + 1, end = rest.find('\n', from))
      take_line(rest.substr(from, end - from));
    rest.erase(0, from);
  }
  if (!rest.empty()) take_line(rest);
  return {};
}

std::string last_word_of(std::string said, std::string_view speaker, int status) {
  if (said.starts_with(speaker)) said.erase(0, speaker.size());
  if (WIFSIGNALED(status)) said += " (ended by signal " + std::to_string(WTERMSIG(status)) + ")";
  if (said.empty()) said = "it ended with status " + std::to_string(status) + " and said nothing";
  return said;
}

}  // namespace tiltfeed::config
