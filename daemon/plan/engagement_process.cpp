#include "daemon/plan/engagement_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

#include "config/beside_program.h"

namespace tiltfeed::daemon {
namespace {

constexpr int kMeasured = 3, kFirstKept = 10;  // descriptors, as the process has them and as it gets them
constexpr int kWaits = 100;                    // ms between looks at whether the user wants it to end
constexpr std::string_view kShare = "progress ", kFigures = "operation ", kHead = "operation,",
                           kName = "tiltfeed-sim engagement: ";

class MeasuringProcess {
 public:
  ~MeasuringProcess() {
    if (hear_ >= 0) ::close(hear_);
    if (pid_ < 0) return;
    ::kill(pid_, SIGKILL);
    wait();
  }
  Result<void> start(const std::vector<std::string>& words, int program);
  Result<MeasuredEngagement> listen(const StageProgress& progress);

 private:
  int wait() {
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    return status;
  }
  void take(const std::string& line);

  int pid_ = -1, hear_ = -1;
  double share_ = 0.0;
  MeasuredEngagement found_;
  std::string said_;  ///< what is neither progress nor a figure
};

Result<void> MeasuringProcess::start(const std::vector<std::string>& words, int program) {
  std::array<int, 2> ends{-1, -1};
  const int text = ::fcntl(program, F_DUPFD_CLOEXEC, kFirstKept);
  int failed = text < 0 || ::pipe2(ends.data(), O_CLOEXEC) != 0 ? errno : 0;
  const int tells = failed == 0 ? ::fcntl(ends[1], F_DUPFD_CLOEXEC, kFirstKept) : -1;
  if (failed == 0 && tells < 0) failed = errno;
  if (failed == 0)
    failed = config::spawn_program(pid_, words,
                                   {{tells, STDOUT_FILENO}, {tells, STDERR_FILENO}, {text, kMeasured}});
  for (const int fd : {text, ends[1], tells})
    if (fd >= 0) ::close(fd);
  hear_ = ends[0];
  if (failed == 0) return {};
  pid_ = -1;
  return fail(Code::kIo,
              words.front() + ": " + std::strerror(failed) +
                  "; it measures what the cutter has to do and belongs beside tiltfeed: install both, "
                  "or leave out --optimise feed");
}

void MeasuringProcess::take(const std::string& line) {
  if (line.starts_with(kShare)) {
    share_ = std::strtod(line.c_str() + kShare.size(), nullptr);
    return;
  }
  if (line.starts_with(kHead)) return;
  std::size_t operation = 0;
  double seconds = 0.0;
  if (line.starts_with(kFigures) &&
      std::sscanf(line.c_str(), "operation %zu: %lf s", &operation, &seconds) == 2) {
    found_.seconds.resize(std::max(found_.seconds.size(), operation));
    found_.seconds[operation - 1] = seconds;
    return;
  }
  EngagedRow row;
  unsigned long long first = 0, last = 0;
  if (std::sscanf(line.c_str(), "%zu,%llu,%lf,%llu,%lf,%lf,%*f,%*f,%*f,%lf,%lf,%lf,%lf,%lf", &operation,
                  &first, &row.first_share, &last, &row.last_share, &row.way, &row.chip, &row.edge_load,
                  &row.turn_load, &row.asked, &row.took) == 11 &&
      operation > 0) {
    row.first_behind = first, row.last_behind = last;
    found_.rows.resize(std::max(found_.rows.size(), operation));
    found_.rows[operation - 1].push_back(row);
    return;
  }
  said_ += (said_.empty() ? "" : "\n") + line;
}

Result<MeasuredEngagement> MeasuringProcess::listen(const StageProgress& progress) {
  std::string rest;
  while (true) {
    pollfd look{hear_, POLLIN, 0};
    const int ready = ::poll(&look, 1, kWaits);
    if (progress && !progress(share_)) return fail(Code::kCancelled, "cancelled; nothing was written");
    if (ready <= 0) continue;
    std::array<char, 65536> bytes;
    const ssize_t count = ::read(hear_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    rest.append(bytes.data(), static_cast<std::size_t>(count));
    std::size_t from = 0;
    for (auto end = rest.find('\n'); end != rest.npos; from = end + 1, end = rest.find('\n', from))
      take(rest.substr(from, end - from));
    rest.erase(0, from);
  }
  const int status = wait();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    found_.rows.resize(found_.seconds.size());
    return std::move(found_);
  }
  said_ += rest;
  if (said_.starts_with(kName)) said_.erase(0, kName.size());
  if (WIFSIGNALED(status)) said_ += " (ended by signal " + std::to_string(WTERMSIG(status)) + ")";
  if (said_.empty()) said_ = "it ended with status " + std::to_string(status) + " and said nothing";
  return fail(Code::kInput, "the engagement is not known, nothing was written: " + said_);
}

}  // namespace

Result<MeasuredEngagement> measure_engagement(const EngagementRequest& request, int program,
                                              const StageProgress& progress) {
  const auto simulator = config::program_beside("tiltfeed-sim");
  if (!simulator) return tl::unexpected(simulator.error());
  std::vector<std::string> words{
      *simulator, "engagement", request.job, "/dev/fd/" + std::to_string(kMeasured),
      "--out",    "-",          "--progress"};
  const std::pair<const char*, const std::string&> stated[] = {{"--stl", request.stl},
                                                               {"--machine", request.machine},
                                                               {"--operation", request.operation},
                                                               {"--stock", request.stock}};
  for (const auto& [option, value] : stated)
    if (!value.empty()) words.emplace_back(option), words.push_back(value);
  MeasuringProcess process;
  if (auto started = process.start(words, program); !started) return tl::unexpected(started.error());
  return process.listen(progress);
}

}  // namespace tiltfeed::daemon
