#include "daemon/service/planner.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <vector>

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

namespace {

Result<PlanProcess> start_logged(std::uint64_t job, const std::string& folder, const char* log,
                                 const std::vector<std::string>& words) {
  constexpr mode_t kOwner = 0600;
  const std::string path = folder + "/" + log;
  PlanProcess started;
  started.job = job, started.folder = folder, started.log = log;
  const int out = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kOwner);
  if (out < 0) return fail(Code::kIo, path + ": " + std::strerror(errno));
  const int failed = started.process.start(words, {{out, STDOUT_FILENO}, {out, STDERR_FILENO}}, folder);
  ::close(out);
  if (failed != 0) return fail(Code::kIo, folder + ": planning cannot be started: " + std::strerror(failed));
  give_up_first(started.process.pid());
  return started;
}

Result<PlanProcess> start_planner(std::uint64_t job, const std::string& folder, const std::string& machine,
                                  const char* alone) {
  ::unlink((folder + "/" + kProgress).c_str());  // of an earlier attempt
  return start_logged(job, folder, "plan.log",
                      {config::kThisProgram, "plan", "job.yaml", "--out", "program.nc", "--cl", "path.cls",
                       "--report", "report.json", "--map", "block.map", "--stl", "part.stl", "--machine",
                       machine, "--progress", kProgress, alone});
}

}  // namespace

Result<PlanProcess> start_plan(std::uint64_t job, const std::string& folder, const std::string& machine) {
  return start_planner(job, folder, machine, "--alone");
}

Result<PlanProcess> start_foreign_plan(const std::string& folder) {
  constexpr int kLast = 19;
  Result<PlanProcess> started = start_planner(0, folder, kForeignProfile, "--closed");
  // Its threads and processes have what it has when they begin.
  if (started)
    static_cast<void>(::setpriority(PRIO_PROCESS, static_cast<id_t>(started->process.pid()), kLast));
  return started;
}

Result<PlanProcess> start_proof(std::uint64_t job, const std::string& folder, const std::string& machine) {
  const auto prover = config::program_beside("tiltfeed-sim");
  if (!prover) return tl::unexpected<Error>(prover.error());
  return start_logged(
      job, folder, "proof.log",
      {*prover, "prove", "job.yaml", "program.nc", "--stl", "part.stl", "--machine", machine, "--closed"});
}

Result<void> compare_figures(const std::string& folder) {
  constexpr std::size_t kHeader = 8192;  // bytes in which the header's word is
  constexpr double kSame = 1e-9;         // both are printed to 0.0001 mm
  std::string head(kHeader, '\0'), found;
  std::ifstream program(folder + "/program.nc", std::ios::binary);
  program.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(program.gcount()));
  std::ifstream log(folder + "/proof.log");
  std::getline(log, found);
  unsigned long long stated_moves = 0, moves = 0;
  double stated = 0.0, gouge = 0.0;
  const std::size_t at = head.find("proof gouge ");
  const bool states = at != head.npos && std::sscanf(head.c_str() + at, "proof gouge %lf mm moves %llu",
                                                     &stated, &stated_moves) == 2;
  if (!states || std::sscanf(found.c_str(), "proven %llu moves, largest gouge %lf mm", &moves, &gouge) != 2)
    return fail(Code::kInput, "its header states no proof");
  if (moves == stated_moves && std::abs(gouge - stated) < kSame) return {};
  return fail(Code::kInput, "its header states " + std::to_string(stated_moves) + " moves and a gouge of " +
                                std::to_string(stated) + " mm, and the proof here found " +
                                std::to_string(moves) + " and " + std::to_string(gouge));
}

void give_up_first(int pid) {
  constexpr const char* kMost = "1000";
  std::ofstream("/proc/" + std::to_string(pid) + "/oom_score_adj") << kMost;
}

std::optional<Result<void>> check_plan(PlanProcess& process) {
  const std::optional<int> status = process.process.ended();
  if (!status) return std::nullopt;
  if (*status == 0) return Result<void>{};
  const std::string words = last_words(process.folder + "/" + process.log);
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
