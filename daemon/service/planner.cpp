#include "daemon/service/planner.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace tiltfeed::daemon {

namespace {

constexpr const char* kProgress = "plan.progress";

/// The last line of the log that says something, without anything unprintable.
std::string last_words(const std::string& log) {
  std::ifstream in(log);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    std::string kept;
    for (const char c : line)
      if (c >= ' ' && c < 0x7F && kept.size() < 500) kept += c;
    if (!kept.empty()) last = kept;
  }
  return last;
}

}  // namespace

Result<PlanProcess> start_plan(std::uint64_t job, const std::string& folder, const std::string& machine) {
  constexpr mode_t kOwner = 0600;
  const std::string log = folder + "/plan.log";
  PlanProcess process;
  process.job = job, process.folder = folder;
  ::unlink((folder + "/" + kProgress).c_str());  // of an earlier attempt
  const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kOwner);
  if (out < 0) return fail(Code::kIo, log + ": " + std::strerror(errno));
  const int failed =
      process.process.start({config::kThisProgram, "plan", "job.yaml", "--out", "program.nc", "--cl",
                             "path.cls", "--report", "report.json", "--map", "block.map", "--stl", "part.stl",
                             "--machine", machine, "--progress", kProgress, "--alone"},
                            {{out, STDOUT_FILENO}, {out, STDERR_FILENO}}, folder);
  ::close(out);
  if (failed != 0) return fail(Code::kIo, folder + ": planning cannot be started: " + std::strerror(failed));
  give_up_first(process.process.pid());
  return process;
}

void give_up_first(int pid) {
  constexpr const char* kMost = "1000";
  std::ofstream("/proc/" + std::to_string(pid) + "/oom_score_adj") << kMost;
}

std::optional<Result<void>> check_plan(PlanProcess& process) {
  const std::optional<int> status = process.process.ended();
  if (!status) return std::nullopt;
  if (*status == 0) return Result<void>{};
  const std::string words = last_words(process.folder + "/plan.log");
  if (WIFSIGNALED(*status))
    return fail(Code::kInput,
                "planning was ended by signal " + std::to_string(WTERMSIG(*status)) + "; " + words);
  return fail(Code::kInput, words.empty() ? "planning failed" : words);
}

std::optional<PlanStage> stage_of(const std::string& folder) {
  std::ifstream in(folder + "/" + kProgress);
  PlanStage at;
  std::string line;
  if (!(in >> at.percent) || !std::getline(in >> std::ws, line) || at.percent < 0 || at.percent > 100)
    return std::nullopt;
  for (const char c : line.substr(0, line.find_last_not_of(' ') + 1))
    at.stage += c >= ' ' && c <= '~' ? c : '?';
  return at;
}

void stop_plan(PlanProcess& process) { process.process.end(); }

}  // namespace tiltfeed::daemon
