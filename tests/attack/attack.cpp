// The random attack: random parts and jobs from seeds, planned, posted and judged by brute force, each in a
// process of its own with a cap on its processor time. `attack --help` has the options.

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include "tests/attack/attack_case.h"
#include "tests/attack/random_job.h"

extern char** environ;

namespace tiltfeed::attack {
using namespace pathgen;
using namespace config;
namespace {

constexpr const char* kHelp =
    "attack [--cases N | --seconds N] [--first SEED] [--models FOLDER] [--out FOLDER] [--jobs N] [--cap "
    "SECONDS]\n"
    "attack --one SEED [--models FOLDER] [--out FOLDER]      one case, judged in this process\n"
    "attack --job JOB.yaml                                   a job as written by a case that failed\n"
    "  --cases N      seeds SEED to SEED + N - 1 (default 100)\n"
    "  --seconds N    as many seeds as begin within that time\n"
    "  --first SEED   default 1\n"
    "  --models FOLDER  STL files at any depth, to choose from besides the formula parts\n"
    "  --out FOLDER   job and part of every case with a finding stay there (default attack)\n"
    "  --jobs N       cases at the same time (default: one for each core)\n"
    "  --cap SECONDS  of processor time for one case: more is a finding (default 60)\n";

/// A line of progress after so many cases.
constexpr std::uint64_t kHeartbeat = 50;

struct Options {
  std::uint64_t first = 1, cases = 100, one = 0;
  double seconds = 0.0;
  unsigned jobs = std::max(1u, std::thread::hardware_concurrency()), cap = 60;
  std::string models, out = "attack", job;
};

std::vector<std::string> stl_files(const std::string& folder) {
  std::vector<std::string> found;
  if (folder.empty() || !std::filesystem::is_directory(folder)) return found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".stl") found.push_back(entry.path().string());
  std::sort(found.begin(), found.end());
  return found;
}

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\t'; }, ' ');
  return text;
}

/// What the case's process prints: a line of figures, then lines of words.
void print(const CaseResult& r) {
  const Verdict& v = r.verdict;
  std::printf("%.9g %.9g %.9g %.9g %zu %zu %zu %.3f %.3f %zu %zu %zu %zu\n", v.gouge, v.rapid, v.contact,
              v.left, v.poses, v.surface_points, v.stock_places, r.plan_seconds, r.judge_seconds, r.facets,
              r.moves, r.damaged, r.damaged_refused);
  std::printf("%s\n%s\n", one_line(r.story).c_str(), one_line(r.refusal).c_str());
  for (const std::string& finding : v.findings) std::printf("%s\n", one_line(finding).c_str());
}

bool parse(const std::string& text, CaseResult& r) {
  std::istringstream in(text);
  Verdict& v = r.verdict;
  in >> v.gouge >> v.rapid >> v.contact >> v.left >> v.poses >> v.surface_points >> v.stock_places >>
      r.plan_seconds >> r.judge_seconds >> r.facets >> r.moves >> r.damaged >> r.damaged_refused;
  std::string line;
  if (!std::getline(in, line) || !std::getline(in, r.story) || !std::getline(in, r.refusal)) return false;
  while (std::getline(in, line)) v.findings.push_back(line);
  return true;
}

/// In a process of its own; how that ended when it did not print a verdict.
CaseResult run_apart(std::uint64_t seed, const Options& o) {
  std::vector<std::string> held{
      "/proc/self/exe",     "--one", std::to_string(seed), "--models", o.models, "--out", o.out, "--cap",
      std::to_string(o.cap)};
  std::vector<char*> words;
  for (std::string& word : held) words.push_back(word.data());
  words.push_back(nullptr);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) std::perror("attack: pipe"), std::exit(2);
  const std::string log = o.out + "/" + std::to_string(seed) + ".log";
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  pid_t child = 0;
  const int failed = posix_spawn(&child, held[0].c_str(), &files, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  close(ends[1]);
  if (failed != 0) std::fprintf(stderr, "attack: %s\n", std::strerror(failed)), std::exit(2);
  std::string text;
  char buffer[4096];
  for (ssize_t got; (got = read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, got);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  CaseResult result;
  const bool ended = WIFEXITED(status) && WEXITSTATUS(status) == 0 && parse(text, result);
  if (ended) return std::filesystem::remove(log), result;
  result.verdict.findings.push_back(
      WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)
          ? "over " + std::to_string(o.cap) + " s of processor time"
      : WIFSIGNALED(status) ? std::string("ended by signal: ") + strsignal(WTERMSIG(status)) + ", see " + log
                            : "ended with " + std::to_string(WEXITSTATUS(status)) + ", see " + log);
  return result;
}

/// A message without its figures, so that refusals of one kind count together.
std::string kind_of(const std::string& message) {
  std::string kind;
  for (const char c :
       message.substr(message.rfind(".yaml:") == std::string::npos ? 0 : message.rfind(".yaml:")))
    if (!(c >= '0' && c <= '9') && c != '.' && c != '-') kind += c;
  return kind.substr(0, 110);
}

class Campaign {
 public:
  explicit Campaign(const Options& options) : o_(options) {}

  int run() {
    prepare(o_.out);
    std::vector<std::thread> workers;
    for (unsigned i = 0; i < o_.jobs; ++i) workers.emplace_back([this] { work(); });
    for (std::thread& worker : workers) worker.join();
    summary();
    return findings_ == 0 && planned_ > 0 ? 0 : 1;
  }

 private:
  void work() {
    const auto elapsed = [this] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    };
    for (;;) {
      const std::uint64_t done = next_++;
      if (o_.seconds > 0.0 ? elapsed() >= o_.seconds : done >= o_.cases) return;
      const CaseResult result = run_apart(o_.first + done, o_);
      const std::lock_guard lock(mutex_);
      take(o_.first + done, result);
    }
  }

  void take(std::uint64_t seed, const CaseResult& r) {
    const Verdict& v = r.verdict;
    const std::string base = o_.out + "/" + std::to_string(seed);
    ++cases_;
    seconds_ += r.plan_seconds + r.judge_seconds;
    if (r.plan_seconds > slowest_) slowest_ = r.plan_seconds, slowest_seed_ = seed;
    if (!r.refusal.empty()) ++refused_, ++reasons_[kind_of(r.refusal)];
    if (r.refusal.empty() && v.findings.empty()) {
      ++planned_, poses_ += v.poses, points_ += v.surface_points, stock_ += v.stock_places;
      damaged_ += r.damaged, damaged_refused_ += r.damaged_refused;
      worst_ = {std::max(worst_.gouge, v.gouge),
                std::max(worst_.rapid, v.rapid),
                0.0,
                std::max(worst_.contact, v.contact),
                std::max(worst_.left, v.left),
                0,
                0,
                0,
                {}};
    }
    for (const std::string& finding : v.findings)
      std::printf("seed %llu (%s): %s; %s.yaml\n", static_cast<unsigned long long>(seed), r.story.c_str(),
                  finding.c_str(), base.c_str());
    if (cases_ % kHeartbeat == 0)
      std::printf("%llu cases, %llu findings\n", static_cast<unsigned long long>(cases_),
                  static_cast<unsigned long long>(findings_));
    std::fflush(stdout);
    if (!v.findings.empty()) return void(++findings_);
    for (const char* ending : {".yaml", ".stl"}) std::filesystem::remove(base + ending);
  }

  void summary() const {
    std::printf(
        "%llu cases from seed %llu: %llu planned and judged within the tolerance, %llu refused, %llu with "
        "findings\n"
        "of those within: gouge %.4f, rapid %.4f, contact %.4f, left over what passes must leave %.4f mm; "
        "%zu poses, "
        "%zu places of the surface, %zu of blanks that rapids pass\n"
        "the proof agrees with them on every program and on %zu damaged moves, of which it refuses %zu\n"
        "%.1f s of processor time, slowest plan %.2f s (seed %llu)\n",
        static_cast<unsigned long long>(cases_), static_cast<unsigned long long>(o_.first),
        static_cast<unsigned long long>(planned_), static_cast<unsigned long long>(refused_),
        static_cast<unsigned long long>(findings_), worst_.gouge, worst_.rapid, worst_.contact, worst_.left,
        poses_, points_, stock_, damaged_, damaged_refused_, seconds_, slowest_,
        static_cast<unsigned long long>(slowest_seed_));
    for (const auto& [reason, count] : reasons_)
      std::printf("  refused %4llu: %s\n", static_cast<unsigned long long>(count), reason.c_str());
  }

  const Options& o_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::atomic<std::uint64_t> next_{0};
  std::mutex mutex_;
  std::uint64_t cases_ = 0, planned_ = 0, refused_ = 0, findings_ = 0, slowest_seed_ = 0;
  std::size_t poses_ = 0, points_ = 0, stock_ = 0, damaged_ = 0, damaged_refused_ = 0;
  double seconds_ = 0.0, slowest_ = 0.0;
  Verdict worst_;
  std::map<std::string, std::uint64_t> reasons_;
};

int serve_one(const Options& o) {
  const rlimit cap{o.cap, o.cap + 2};
  setrlimit(RLIMIT_CPU, &cap);
  const rlimit core{0, 0};
  setrlimit(RLIMIT_CORE, &core);
  // The processor time of a case is that of its own thread.
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  print(o.job.empty() ? run_case(o.one, {o.out, stl_files(o.models)}) : run_job(o.job));
  return std::fflush(stdout) == 0 ? 0 : 1;
}

bool read_options(int argc, char** argv, Options& o) {
  for (int i = 1; i < argc; i += 2) {
    const std::string word = argv[i];
    if (i + 1 >= argc) return false;
    const char* value = argv[i + 1];
    if (word == "--cases")
      o.cases = std::strtoull(value, nullptr, 10);
    else if (word == "--seconds")
      o.seconds = std::strtod(value, nullptr);
    else if (word == "--first")
      o.first = std::strtoull(value, nullptr, 10);
    else if (word == "--one")
      o.one = std::strtoull(value, nullptr, 10);
    else if (word == "--models")
      o.models = value;
    else if (word == "--out")
      o.out = value;
    else if (word == "--job")
      o.job = value;
    else if (word == "--jobs")
      o.jobs = static_cast<unsigned>(std::strtoul(value, nullptr, 10));
    else if (word == "--cap")
      o.cap = static_cast<unsigned>(std::strtoul(value, nullptr, 10));
    else
      return false;
  }
  return o.jobs > 0 && o.cap > 0;
}

}  // namespace
}  // namespace tiltfeed::attack

int main(int argc, char** argv) {
  using namespace tiltfeed::attack;
  Options options;
  if (!read_options(argc, argv, options)) return std::fputs(kHelp, stderr), 2;
  try {
    // Of many cases at a time none may find the machine half written.
    const bool is_prepared = std::filesystem::exists(options.out + "/wide.yaml");
    if (options.one > 0 && !is_prepared) prepare(options.out);
    if (options.one > 0 || !options.job.empty()) return serve_one(options);
    return Campaign(options).run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "attack: %s\n", error.what());
    return 2;
  }
}
