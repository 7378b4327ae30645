// Measures the planner: time, memory, how both grow, and how far they are from what is possible.
// Options: those of Google Benchmark (--benchmark_filter=...), and
//   --folder FOLDER     where the parts' STL files are made
//   --rows FILE         more rows for the table: name, seconds and remark, with tabs between
//   --markdown FILE     the table

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pathgen/mesh/mesh_check.h"
#include "tests/bench/bench_table.h"
#include "tests/bench/height_map.h"
#include "tests/bench/markdown.h"
#include "tests/bench/workload.h"
#include "tests/bench/z_map.h"

namespace tiltfeed::bench {
using namespace pathgen;
using namespace config;
namespace {

using benchmark::State;

std::string folder = "bench";

constexpr std::array<const char*, 4> kParts{"tyre", "pin", "handle", "sphere"};
constexpr std::array<std::size_t, 5> kFacetSeries{250'000, 500'000, 1'000'000, 2'000'000, 4'000'000};
constexpr std::array<std::size_t, 3> kFieldFacets{250'000, 1'000'000, 4'000'000};
constexpr std::array<std::size_t, 3> kMillionPoints{1, 5, 20};
/// Of the mode free, mm: each next one gives twice the points.
constexpr std::array<double, 4> kFreeSteps{2.0, 1.0, 0.5, 0.25};
constexpr int kRepetitions = 5;
/// Two programs of as many points: within this share.
constexpr double kSamePoints = 0.01;
/// Of the height map, mm, and how far rounding may take it from the exact drop.
constexpr double kGridStep = 0.2, kGridRounding = 1e-6;
constexpr int kGridSamples = 2'000;
/// Turns of ours and the bare z-map.
constexpr int kTurns = 3;

std::string job_file(const std::string& part) { return SOURCE_DIR "/config/jobs/" + part + ".yaml"; }

Result<Workload> workload(const std::string& part, std::size_t facets = 0, const std::string& mode = "") {
  auto file = part_file(folder, part, facets);
  if (!file) return tl::unexpected(file.error());
  Workload work;
  work.job = job_file(part + mode), work.stl = *file;
  return work;
}

/// A sample, or none with the benchmark marked as failed.
bool measured(State& state, const Workload& work, Sample& sample) {
  auto got = measure_apart(work);
  if (!got) return state.SkipWithError(got.error().message.c_str()), false;
  sample = std::move(*got);
  return true;
}

void set_counters(State& state, const Sample& s) {
  state.counters["wall_s"] = s.seconds;
  state.counters["processor_s"] = s.processor_seconds;
  state.counters["facets"] = static_cast<double>(s.facets);
  state.counters["points"] = static_cast<double>(s.points);
  state.counters["envelope_points"] = static_cast<double>(s.envelope_points);
  state.counters["peak_bytes"] = static_cast<double>(s.peak_bytes);
  if (s.cl_points == 0) return;
  state.counters["cl_points"] = static_cast<double>(s.cl_points);
  state.counters["directions"] = static_cast<double>(s.directions);
}

void stl_to_path(State& state, const Workload& work) {
  Sample s;
  for (auto _ : state) {
    if (!measured(state, work, s)) return;
    state.SetIterationTime(s.seconds);
  }
  set_counters(state, s);
  int order = 0;
  for (const StageTime& stage : s.stages)
    state.counters[share_name(order++, stage.stage)] = 100.0 * stage.seconds / s.seconds;
}

/// Passes of `work` at another side step, so that its path has `points` within `share`.
Result<Sample> fit_side_step(Workload& work, double points, double share) {
  constexpr int kTries = 12;
  auto job = load(work);
  if (!job) return tl::unexpected(job.error());
  work.side_step = job->plan.pattern.side_step;
  for (int tries = 0; tries < kTries; ++tries) {
    auto sample = measure_apart(work);
    if (!sample) return sample;
    const double got = static_cast<double>(sample->points);
    if (std::abs(got - points) <= share * points) return sample;
    work.side_step *= got / points;
  }
  return fail(Code::kLimit, "no side step gives " + grouped(points) + " points");
}

/// The job as it is and with a fixed axis, as many points, in turns; each repetition is one pair.
void axis_ratio(State& state, const std::string& part) {
  static std::map<std::string, std::array<Workload, 2>> fitted;
  if (!fitted.contains(part)) {
    auto work = workload(part);
    if (!work) return state.SkipWithError(work.error().message.c_str());
    work->any_tilt = true;
    Workload fixed = *work;
    fixed.fixed = true;
    Sample s;
    if (!measured(state, *work, s)) return;
    if (auto found = fit_side_step(fixed, static_cast<double>(s.points), kSamePoints); !found)
      return state.SkipWithError(found.error().message.c_str());
    fitted[part] = {*work, fixed};
  }
  const auto& [work, fixed] = fitted[part];
  static bool turn = false;
  Sample deformed, three;
  for (auto _ : state) {
    turn = !turn;
    if (turn && !measured(state, fixed, three)) return;
    if (!measured(state, work, deformed)) return;
    if (!turn && !measured(state, fixed, three)) return;
    state.SetIterationTime(deformed.seconds);
  }
  set_counters(state, deformed);
  state.counters["ratio"] = deformed.seconds / three.seconds;
  state.counters["processor_ratio"] = deformed.processor_seconds / three.processor_seconds;
  state.counters["fixed_points"] = static_cast<double>(three.points);
  state.counters["fixed_envelope_points"] = static_cast<double>(three.envelope_points);
  state.counters["fixed_side_step"] = fixed.side_step;
}

void part_series(State& state, const std::string& part) {
  const auto work = workload(part);
  if (!work) return state.SkipWithError(work.error().message.c_str());
  stl_to_path(state, *work);
}

/// The mode free, at the job's side step or another one (mm).
void free_series(State& state, const std::string& part, double side_step) {
  auto work = workload(part, 0, "_free");
  if (!work) return state.SkipWithError(work.error().message.c_str());
  work->side_step = side_step;
  stl_to_path(state, *work);
  if (side_step > 0.0) state.counters["side_step"] = side_step;
}

void facet_series(State& state, std::size_t facets) {
  const auto work = workload("tyre", facets);
  if (!work) return state.SkipWithError(work.error().message.c_str());
  stl_to_path(state, *work);
}

/// Memory that can be had without swapping.
double available_bytes() {
  std::ifstream in("/proc/meminfo");
  std::string line;
  while (std::getline(in, line))
    if (line.starts_with("MemAvailable:")) return std::stod(line.substr(13)) * 1024.0;
  return 0.0;
}

/// The tyre at the side step that gives so many million points: points go with its inverse.
void point_series(State& state, std::size_t millions) {
  static double step_times_points = 0.0, bytes_per_million = 0.0;
  auto work = workload("tyre");
  if (!work) return state.SkipWithError(work.error().message.c_str());
  if (step_times_points == 0.0) {
    Workload first = *work;
    const auto sample = fit_side_step(first, 1e6, kSamePoints);
    if (!sample) return state.SkipWithError(sample.error().message.c_str());
    step_times_points = first.side_step * static_cast<double>(sample->points);
    bytes_per_million = static_cast<double>(sample->peak_bytes);
  }
  if (bytes_per_million * static_cast<double>(millions) > available_bytes())
    return state.SkipWithError((kSkipped + std::string(": not so much memory is free")).c_str());
  work->side_step = step_times_points / (static_cast<double>(millions) * 1e6);
  stl_to_path(state, *work);
  state.counters["side_step"] = work->side_step;
}

/// What the machine itself gives to a second thread: a loop that shares nothing and stays in registers, on
/// one thread and on two at once.
double machine_ratio() {
  const auto loop = [] {
    std::array<std::uint64_t, 8> v{1, 2, 3, 4, 5, 6, 7, 8};
    for (std::uint64_t k = 0; k < 60'000'000; ++k)
      for (std::size_t i = 0; i < v.size(); ++i) v[i] = (v[i] + (k ^ i)) ^ v[(i + 3) % v.size()];
    benchmark::DoNotOptimize(v);
  };
  const auto seconds = [](const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const double one = seconds(loop);
  const double two = seconds([&] {
    const std::jthread other(loop);
    loop();
  });
  return 2.0 * one / two;
}

void thread_ratio(State& state) {
  auto work = workload("tyre");
  if (!work) return state.SkipWithError(work.error().message.c_str());
  Sample one, two;
  for (auto _ : state) {
    work->threads = 1;
    if (!measured(state, *work, one)) return;
    work->threads = 2;
    if (!measured(state, *work, two)) return;
    state.SetIterationTime(two.seconds);
  }
  set_counters(state, two);
  state.counters["ratio"] = one.seconds / two.seconds;
  state.counters["processor_ratio"] = one.processor_seconds / two.processor_seconds;
  state.counters["machine_ratio"] = machine_ratio();
}

/// The limit: the file's bytes, and one pass over its numbers.
void read_and_pass(State& state) {
  const auto work = workload("tyre");
  if (!work) return state.SkipWithError(work.error().message.c_str());
  double facets = 0.0, bytes = 0.0;
  for (auto _ : state) {
    std::ifstream in(work->stl, std::ios::binary | std::ios::ate);
    std::vector<char> text(static_cast<std::size_t>(in.tellg()));
    in.seekg(0).read(text.data(), static_cast<std::streamsize>(text.size()));
    float high = -1e30F;
    for (std::size_t at = 84; at + 50 <= text.size(); at += 50) {
      float corners[12];
      std::memcpy(corners, text.data() + at, sizeof corners);
      for (const float c : corners) high = std::max(high, c);
    }
    benchmark::DoNotOptimize(high);
    bytes = static_cast<double>(text.size()), facets = (bytes - 84.0) / 50.0;
  }
  state.counters["facets"] = facets;
  state.counters["bytes"] = bytes;
}

/// The plain height map against our stages after the check of the mesh, both on one thread, and both for
/// the whole part with a fixed axis.
void plain_height_map(State& state, const std::string& part) {
  auto work = workload(part);
  if (!work) return state.SkipWithError(work.error().message.c_str());
  work->fixed = true, work->any_tilt = true, work->side_step = kGridStep, work->threads = 1;
  const auto job = load(*work);
  if (!job) return state.SkipWithError(job.error().message.c_str());
  const auto stl = read_stl(job->stl_path, job->stl_unit_mm);
  const auto checked = stl ? check_mesh(*stl) : tl::unexpected(stl.error());
  if (!checked) return state.SkipWithError(checked.error().message.c_str());
  const AxisFrame& frame = job->plan.axis;
  const double radius = job->plan.cutter.radius();
  HeightMap map;
  for (auto _ : state) map = height_map(checked->mesh, frame, radius, kGridStep);
  if (!(largest_error(map, checked->mesh, frame, radius, kGridSamples) <= kGridRounding))
    return state.SkipWithError("the height map is not the exact drop of the ball");
  Sample s;
  if (!measured(state, *work, s)) return;
  set_counters(state, s);
  state.counters["columns"] = static_cast<double>(map.height.size());
  state.counters["ours_s"] = s.plan_processor_seconds;
}

/// The bare z-map of the smallest field is held to the exact drop.
bool is_exact(const std::string& stl, double radius, double step) {
  static bool asked = false, exact = false;
  if (std::exchange(asked, true)) return exact;
  const auto map = z_map(stl, radius, step);
  const auto read = read_stl(stl, 1.0);
  const auto checked = read ? check_mesh(*read) : tl::unexpected(read.error());
  if (!map || !checked) return false;
  const AxisFrame frame{AxisMode::kFixed, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0};
  return exact = largest_error(*map, checked->mesh, frame, radius, kGridSamples) <= kGridRounding;
}

/// STL to path and the bare z-map of the same height field at the same step, in turns.
void bare_z_map(State& state, std::size_t facets) {
  auto work = workload(kHeightField, facets);
  if (!work) return state.SkipWithError(work.error().message.c_str());
  work->job = SOURCE_DIR "/tests/bench/height_field.yaml";
  const auto job = load(*work);
  if (!job) return state.SkipWithError(job.error().message.c_str());
  const double radius = job->plan.cutter.radius(), step = job->plan.pattern.side_step;
  if (!is_exact(work->stl, radius, step))
    return state.SkipWithError("the z-map is not the exact drop of the ball");
  Sample ours, bare;
  for (auto _ : state) {
    if (!measured(state, *work, ours)) return;
    auto got = measure_z_map_apart(work->stl, radius, step);
    if (!got) return state.SkipWithError(got.error().message.c_str());
    bare = std::move(*got);
    state.SetIterationTime(ours.seconds);
  }
  set_counters(state, ours);
  state.counters["z_map_columns"] = static_cast<double>(bare.points);
  state.counters["z_map_s"] = bare.seconds;
  state.counters["ratio"] = ours.seconds / bare.seconds;
  state.counters["processor_ratio"] = ours.processor_seconds / bare.processor_seconds;
}

template <class Run, class... Arguments>
void add_series(const std::string& name, int repetitions, Run run, Arguments... arguments) {
  benchmark::RegisterBenchmark(name.c_str(), [=](State& state) { run(state, arguments...); })
      ->UseManualTime()
      ->Iterations(1)
      ->Repetitions(repetitions)
      ->ReportAggregatesOnly(repetitions > 1)
      ->Unit(benchmark::kMillisecond);
}

void register_all() {
  for (const std::string part : kParts)
    if (std::ifstream(job_file(part)))
      add_series("stl_to_path/" + part, kRepetitions, part_series, part);
    else
      std::fprintf(stderr, "plan_bench: %s is absent: skipped\n", job_file(part).c_str());
  for (const std::string part : {"tyre", "pin", "sphere"})
    add_series("axis_ratio/" + part, kRepetitions, axis_ratio, part);
  for (const std::size_t facets : kFacetSeries)
    add_series("facets/" + std::to_string(facets), 1, facet_series, facets);
  for (const std::size_t millions : kMillionPoints)
    add_series("points/" + std::to_string(millions) + "M", 1, point_series, millions);
  for (const std::string part : {"sphere", "handle"})
    add_series("free/" + part, kRepetitions, free_series, part, 0.0);
  for (const double step : kFreeSteps)
    add_series("free_step/" + formatted("%g", step), 1, free_series, std::string("sphere"), step);
  add_series("threads/tyre", kRepetitions, thread_ratio);
  for (const std::size_t facets : kFieldFacets)
    add_series("z_map/" + std::to_string(facets), kTurns, bare_z_map, facets);
  benchmark::RegisterBenchmark("limit/read", read_and_pass)->UseRealTime()->Unit(benchmark::kMillisecond);
  for (const std::string part : {"tyre", "pin"})
    benchmark::RegisterBenchmark(("height_map/" + part).c_str(),
                                 [part](State& state) { plain_height_map(state, part); })
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace tiltfeed::bench

int main(int argc, char** argv) {
  using namespace tiltfeed::bench;
  int status = 0;
  if (serve(argc, argv, status)) return status;
  benchmark::Initialize(&argc, argv);
  std::string markdown, rows;
  for (int i = 1; i < argc; i += 2) {
    const std::string option = argv[i];
    if (i + 1 == argc || (option != "--folder" && option != "--rows" && option != "--markdown"))
      return std::fprintf(stderr, "plan_bench: unknown option '%s', or it lacks its value\n", argv[i]), 2;
    (option == "--folder" ? folder : option == "--rows" ? rows : markdown) = argv[i + 1];
  }
  register_all();
  BenchTable table;
  benchmark::RunSpecifiedBenchmarks(&table);
  if (!rows.empty()) table.add_rows(rows);
  const std::string text = table.markdown();
  std::printf("\n%s", text.c_str());
  if (!markdown.empty())
    if (auto written = write_file(markdown, text); !written)
      return std::fprintf(stderr, "plan_bench: %s\n", written.error().message.c_str()), 1;
  return table.failed() ? 1 : 0;
}
