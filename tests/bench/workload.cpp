#include "tests/bench/workload.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <charconv>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>

#include "pathgen/mesh/mesh_check.h"
#include "sim/parts/parts.h"
#include "tests/bench/height_field.h"
#include "tests/bench/z_map.h"

extern char** environ;

namespace tiltfeed::bench {
using namespace pathgen;
using namespace config;

namespace {

constexpr const char *kServe = "--measure-one", *kServeZMap = "--measure-z-map";

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](timeval t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// VmHWM starts with the program; ru_maxrss does not: it counts what the parent held before exec.
std::uint64_t peak_bytes() {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line))
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024;
  return 0;
}

void print(const Sample& s, std::ostream& out) {
  out.precision(9);
  out << s.seconds << ' ' << s.processor_seconds << ' ' << s.plan_processor_seconds << ' ' << s.peak_bytes
      << ' ' << s.facets << ' ' << s.points << ' ' << s.envelope_points << ' ' << s.warnings << ' '
      << s.cl_points << ' ' << s.directions << '\n';
  for (const StageTime& t : s.stages) out << t.seconds << ' ' << t.stage << '\n';
}

Result<Sample> read_sample(const std::string& text) {
  std::istringstream in(text);
  Sample s;
  in >> s.seconds >> s.processor_seconds >> s.plan_processor_seconds >> s.peak_bytes >> s.facets >>
      s.points >> s.envelope_points >> s.warnings >> s.cl_points >> s.directions;
  if (!in) return fail(Code::kIo, "the measuring process printed '" + text + "'");
  StageTime stage;
  while (in >> stage.seconds && std::getline(in >> std::ws, stage.stage)) s.stages.push_back(stage);
  return s;
}

}  // namespace

namespace {

Result<Sample> z_map_sample(const std::string& stl, double radius, double step) {
  Sample s;
  const double start = now();
  const auto map = z_map(stl, radius, step);
  if (!map) return tl::unexpected(map.error());
  s.seconds = now() - start, s.processor_seconds = processor_seconds();
  s.peak_bytes = peak_bytes(), s.points = map->height.size();
  return s;
}

std::string exact(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

}  // namespace

AxisFrame fixed_frame(const AxisFrame& axis) {
  AxisFrame fixed{AxisMode::kFixed, Sense::kOutward, axis.origin, axis.t, axis.n, 0.0};
  if (axis.mode != AxisMode::kFixed && axis.sense == Sense::kInward) fixed.n = -axis.n;
  return fixed;
}

Result<Job> load(const Workload& work) {
  auto job = load_job(work.job);
  if (!job) return job;
  if (!work.stl.empty()) job->stl_path = work.stl;
  if (work.side_step > 0.0) job->plan.pattern.side_step = work.side_step;
  if (work.fixed) job->plan.axis = fixed_frame(job->plan.axis);
  if (work.any_tilt) job->plan.tilt_max = Angle::from_degrees(180.0);
  return job;
}

Result<Outcome> stl_to_path(const Job& job, int threads) {
  std::optional<tbb::global_control> limit;
  if (threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, threads);
  Outcome result;
  const double start = now(), processor_start = processor_seconds();
  auto stl = read_stl(job.stl_path, job.stl_unit_mm);
  if (!stl) return tl::unexpected(stl.error());
  const double read = now();
  auto part = check_mesh(*stl);
  if (!part) return tl::unexpected(part.error());
  *stl = Stl{};  // gives its memory back; facets = {} would keep it
  const double checked = now(), plan_processor_start = processor_seconds();
  result.part = std::move(*part);
  auto planned = plan(result.part, job.plan, {});
  if (!planned) return tl::unexpected(planned.error());
  Sample& s = result.sample;
  s.seconds = now() - start;
  s.processor_seconds = processor_seconds() - processor_start;
  s.plan_processor_seconds = processor_seconds() - plan_processor_start;
  s.peak_bytes = peak_bytes();
  const PlanReport& report = planned->report;
  s.facets = report.facets, s.points = report.points, s.envelope_points = report.slice_points;
  s.warnings = report.warnings.size();
  if (report.free) s.cl_points = report.free->cl_points, s.directions = report.free->directions;
  s.stages = {{"read", read - start}, {"check", checked - read}};
  s.stages.insert(s.stages.end(), report.times.begin(), report.times.end());
  result.plan = std::move(*planned);
  return result;
}

Result<std::string> run_apart(const std::vector<std::string>& arguments) {
  std::string program = "/proc/self/exe";
  std::vector<std::string> held = arguments;
  std::vector<char*> words{program.data()};
  for (std::string& word : held) words.push_back(word.data());
  words.push_back(nullptr);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return fail(Code::kIo, "no pipe for the measuring process");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  pid_t child = 0;
  const int spawned = posix_spawn(&child, program.c_str(), &actions, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t n; spawned == 0 && (n = read(ends[0], buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = -1;
  if (spawned != 0 || waitpid(child, &status, 0) != child || status != 0)
    return fail(Code::kIo, "the measuring process failed with status " + std::to_string(status));
  return text;
}

Result<Sample> measure_apart(const Workload& w) {
  const auto text = run_apart({kServe, w.job, w.stl, exact(w.side_step), w.fixed ? "fixed" : "job",
                               w.any_tilt ? "any" : "job", std::to_string(w.threads)});
  if (!text) return tl::unexpected(text.error());
  return read_sample(*text);
}

Result<Sample> measure_z_map_apart(const std::string& stl, double radius, double step) {
  const auto text = run_apart({kServeZMap, stl, exact(radius), exact(step)});
  if (!text) return tl::unexpected(text.error());
  return read_sample(*text);
}

bool serve(int argc, char** argv, int& status) {
  if (argc == 5 && std::string(argv[1]) == kServeZMap) {
    const auto sample = z_map_sample(argv[2], std::strtod(argv[3], nullptr), std::strtod(argv[4], nullptr));
    if (sample) print(*sample, std::cout);
    return status = sample ? 0 : 1, true;
  }
  if (argc != 8 || std::string(argv[1]) != kServe) return false;
  const Workload work{argv[2],
                      argv[3],
                      std::strtod(argv[4], nullptr),
                      std::string(argv[5]) == "fixed",
                      std::string(argv[6]) == "any",
                      static_cast<int>(std::strtol(argv[7], nullptr, 10))};
  const auto job = load(work);
  const auto outcome = job ? stl_to_path(*job, work.threads) : tl::unexpected(job.error());
  if (outcome) {
    print(outcome->sample, std::cout);
    std::cout.flush();
    _exit(0);  // freeing gigabytes piece by piece is no part of the measurement
  }
  std::cerr << outcome.error().message << "\n";
  return status = 1, true;
}

Result<std::string> part_file(const std::string& folder, const std::string& part, std::size_t facets) {
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  const std::string path = folder + "/" + part + (facets > 0 ? "-" + std::to_string(facets) : "") + ".stl";
  if (std::filesystem::exists(path)) return path;
  auto triangles = part == kHeightField ? height_field(facets)
                   : facets > 0         ? sim::tyre_segment(facets)
                                        : sim::part_by_name(part);
  if (!triangles) return tl::unexpected(triangles.error());
  if (auto written = write_stl(path, *triangles); !written) return tl::unexpected(written.error());
  return path;
}

}  // namespace tiltfeed::bench
