#include "daemon/service/planner.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

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
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addchdir_np(&files, folder.c_str());
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "plan.log", O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  const std::string path = "/proc/self/exe";
  std::string words[] = {"tiltfeed", "plan",      "job.yaml",    "--out",      "program.nc", "--cl",
                         "path.cls", "--report",  "report.json", "--map",      "block.map",  "--stl",
                         "part.stl", "--machine", machine,       "--progress", kProgress,    "--alone"};
  char* arguments[std::size(words) + 1] = {};
  for (std::size_t i = 0; i < std::size(words); ++i) arguments[i] = words[i].data();
  ::unlink((folder + "/" + kProgress).c_str());  // of an earlier attempt
  PlanProcess process{-1, job, folder};
  const int failed = ::posix_spawn(&process.pid, path.c_str(), &files, &attributes, arguments, environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (failed != 0) return fail(Code::kIo, folder + ": planning cannot be started: " + std::strerror(failed));
  give_up_first(process.pid);
  return process;
}

void give_up_first(int pid) {
  constexpr const char* kMost = "1000";
  std::ofstream("/proc/" + std::to_string(pid) + "/oom_score_adj") << kMost;
}

std::optional<Result<void>> check_plan(PlanProcess& process) {
  int status = 0;
  if (process.pid < 0 || ::waitpid(process.pid, &status, WNOHANG) != process.pid) return std::nullopt;
  process.pid = -1;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return Result<void>{};
  const std::string words = last_words(process.folder + "/plan.log");
  if (WIFSIGNALED(status))
    return fail(Code::kInput,
                "planning was ended by signal " + std::to_string(WTERMSIG(status)) + "; " + words);
  return fail(Code::kInput, words.empty() ? "planning failed" : words);
}

std::optional<PlanStage> stage_of(const PlanProcess& process) {
  if (process.pid < 0) return std::nullopt;
  std::ifstream in(process.folder + "/" + kProgress);
  PlanStage at;
  std::string line;
  if (!(in >> at.percent) || !std::getline(in >> std::ws, line) || at.percent < 0 || at.percent > 100)
    return std::nullopt;
  for (const char c : line.substr(0, line.find_last_not_of(' ') + 1))
    at.stage += c >= ' ' && c <= '~' ? c : '?';
  return at;
}

void stop_plan(PlanProcess& process) {
  if (process.pid < 0) return;
  ::kill(process.pid, SIGKILL);
  ::waitpid(process.pid, nullptr, 0);
  process.pid = -1;
}

}  // namespace tiltfeed::daemon
