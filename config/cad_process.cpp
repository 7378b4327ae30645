#include "config/cad_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <utility>

#include "config/beside_program.h"
#include "config/child_process.h"
#include "config/description.h"
#include "kinematics/basics/decimal.h"
#include "pathgen/part_file/cad_stream.h"

namespace tiltfeed::config {
namespace {

constexpr const char* kCadProgram = "tiltfeed-cad";
constexpr int kLook = 100;                     // ms between looks at whether the user wants it to end
constexpr std::size_t kMostSaid = 8 * 1024;    // of what it says on standard error
constexpr std::size_t kMostSent = 2ull << 30;  // bytes of its stream
constexpr std::size_t kReadBytes = 256 * 1024;

struct Pipe {
  int read = -1, write = -1;
  bool open() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) return false;
    read = ends[0], write = ends[1];
    return true;
  }
  void close_write() {
    if (write >= 0) ::close(std::exchange(write, -1));
  }
  void close_read() {
    if (read >= 0) ::close(std::exchange(read, -1));
  }
  ~Pipe() { close_write(), close_read(); }
};

/// Reads what is there; at the end it closes the pipe. False: more than `most`.
bool take(Pipe& pipe, std::string& text, std::size_t most) {
  std::array<char, 4096> bytes;
  const std::size_t before = text.size();
  while (text.size() - before < kReadBytes) {
    const ssize_t got = ::read(pipe.read, bytes.data(), bytes.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) break;  // nothing more now
    if (got == 0) {
      pipe.close_read();
      break;
    }
    text.append(bytes.data(), static_cast<std::size_t>(got));
    if (text.size() > most) return false;
  }
  return true;
}

class CadRun {
 public:
  explicit CadRun(const std::string& path) : path_(path) {}

  Result<void> start(const std::vector<std::string>& words) {
    int failed = out_.open() && error_.open() ? 0 : errno;
    if (failed == 0)
      failed = child_.start(words, {{out_.write, STDOUT_FILENO}, {error_.write, STDERR_FILENO}});
    out_.close_write(), error_.close_write();
    if (failed != 0)
      return fail(Code::kIo,
                  path_ + ": a STEP or IGES file, and " + words[0] + ": " + std::strerror(failed) +
                      "; it reads these files: install the package tiltfeed-cad, or export the part as STL "
                      "or 3MF");
    for (const int end : {out_.read, error_.read}) ::fcntl(end, F_SETFL, O_NONBLOCK);
    return {};
  }

  Result<void> listen(const pathgen::ReportShare& report, int wall_seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(wall_seconds);
    while (out_.read >= 0 || error_.read >= 0) {
      std::array<pollfd, 2> look{{{out_.read, POLLIN, 0}, {error_.read, POLLIN, 0}}};
      const int ready = ::poll(look.data(), look.size(), kLook);
      if (report && !report(0.0)) return fail(Code::kCancelled, "cancelled; nothing was written");
      if (std::chrono::steady_clock::now() > end)
        return fail(Code::kLimit, path_ + ": " + kCadProgram + " was stopped after " +
                                      std::to_string(wall_seconds) +
                                      " s; choose bodies, or export the part as STL");
      if (ready <= 0) continue;
      if (look[0].revents != 0 && !take(out_, sent, kMostSent))
        return fail(Code::kLimit, path_ + ": over the limit of " + std::to_string(kMostSent) +
                                      " bytes from " + kCadProgram + "; use a larger tolerance_mm");
      if (look[1].revents != 0) {
        take(error_, said, said.max_size());
        // Its last words count.
        if (said.size() > kMostSaid) said.erase(0, said.size() - kMostSaid);
      }
    }
    return {};
  }

  /// How it ended.
  int wait() { return child_.wait(); }

  std::string sent, said;

 private:
  const std::string& path_;
  Pipe out_, error_;
  ChildProcess child_;  // whose end comes with this one's
};

std::string in_one_line(std::string text) {
  const std::string speaker = std::string(kCadProgram) + ": ";
  for (std::size_t at = text.find(speaker); at != text.npos; at = text.find(speaker))
    text.erase(at, speaker.size());
  while (!text.empty() && text.back() == '\n') text.pop_back();
  for (char& c : text)
    if (c == '\n') c = ' ';
  return text;
}

Error ended(int status, const std::string& said, const std::string& path) {
  const std::string text = in_one_line(said);
  if (!WIFSIGNALED(status) && !text.empty()) return {Code::kInput, text};
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  const bool limit = signal == SIGXCPU || signal == SIGKILL;
  std::string how = signal == 0 ? "ended with status " + std::to_string(WEXITSTATUS(status))
                                : "ended by signal " + std::to_string(signal);
  if (limit) how += ", which is more memory or processor time than it may have";
  const bool told = signal == SIGTERM || signal == SIGINT || signal == SIGHUP;
  return {limit ? Code::kLimit : Code::kInput,
          path + ": the reader of CAD files " + how + (text.empty() ? "" : ": it " + text) +
              (told ? "; it was told to end: start again" : "; export the part again, or as STL")};
}

}  // namespace

Result<pathgen::PartModel> run_cad_program(const std::vector<std::string>& words, const std::string& path,
                                           const pathgen::ReportShare& report, int wall_seconds) {
  CadRun run(path);
  if (auto started = run.start(words); !started) return tl::unexpected(started.error());
  if (auto heard = run.listen(report, wall_seconds); !heard) return tl::unexpected(heard.error());
  if (const int status = run.wait(); status != 0) return tl::unexpected(ended(status, run.said, path));
  return pathgen::read_cad_stream(run.sent, path);
}

Result<pathgen::PartModel> run_cad(const std::string& path, const std::vector<std::string>& bodies,
                                   double allowed, const pathgen::ReportShare& report) {
  const auto program = program_beside(kCadProgram);
  if (!program) return tl::unexpected(program.error());
  std::vector<std::string> words = {*program,      path,
                                    "--stream",    "-",
                                    "--deviation", exact_text(allowed),
                                    "--memory-mb", std::to_string(kCadMemoryMb),
                                    "--seconds",   std::to_string(kCadSeconds)};
  for (const std::string& body : bodies) words.push_back("--body=" + body);
  return run_cad_program(words, path, report, kCadWallSeconds);
}

}  // namespace tiltfeed::config
