// Plans each job and proves its path by brute force: one row of a table for each model.
//   models_table --folder FOLDER --markdown FILE JOB...
// FOLDER: where the STL files of formula parts are made. Jobs or models that are absent are skipped.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/bench/markdown.h"
#include "tests/bench/workload.h"
#include "tests/judges/cover_proof.h"
#include "tests/judges/path_proof.h"

namespace tiltfeed::bench {
using namespace pathgen;
using namespace config;
namespace {

constexpr const char* kServe = "--prove-one";
/// Poses on cutting moves and points of the surface: longer paths are sampled with a stride.
constexpr std::size_t kPoses = 100'000;
constexpr int kSurfacePoints = 5'000;
/// PathProof takes this many poses on a move, or more.
constexpr std::size_t kPosesPerMove = 3;
/// No model may cost more than this many times what the tyre does for each of its facets and envelope points.
constexpr double kMostTimes = 10.0;
/// The job that the others are held against.
constexpr const char* kMeasure = "tyre";
/// Longer messages are cut in the table.
constexpr std::size_t kLongestMessage = 100;

const std::vector<std::string>& heads() {
  static const std::vector<std::string> all{
      "job",         "axis",    "facets",   "envelope points", "points",    "wall s",
      "processor s", "ns each", "times",    "peak MB",         "tolerance", "gouge",
      "contact",     "rapid",   "uncut of", "surface",         "warnings",  "verdict"};
  return all;
}

const char* name_of(AxisMode mode) {
  constexpr const char* kNames[]{"fixed", "point", "line", "circle"};
  return kNames[static_cast<int>(mode)];
}

/// CoverProof's requirements.
bool is_covered_by_passes(const PlanOptions& o) {
  return o.cutter.type == CutterType::kBall && o.pattern.kind == PatternKind::kRaster && o.allowance == 0.0 &&
         o.radial_stock == 0.0 && o.axial_stock == 0.0 && o.containment.boundary.empty() &&
         !o.containment.first.bounded() && !o.containment.second.bounded() && !o.containment.height.bounded();
}

/// The cells of a row after the first.
std::vector<std::string> proven(const Job& job, const Outcome& outcome) {
  const PlanOptions& options = job.plan;
  const Sample& s = outcome.sample;
  const PathProof proof(options.axis, options.pattern.along, options.cutter, options.tolerance, outcome.part,
                        outcome.plan.path, {options.allowance, options.radial_stock, options.axial_stock});
  const std::size_t stride = std::max<std::size_t>(1, kPosesPerMove * s.points / kPoses);
  const Measured m = proof.measure(kPoses, stride);
  std::vector<std::string> faults;
  if (m.gouge > options.tolerance) faults.push_back("gouge at " + pasteable(m.gouge_at));
  if (m.contact > options.tolerance) faults.push_back("contact at " + pasteable(m.contact_at));
  if (m.rapid_overlap > options.tolerance) faults.push_back("rapid at " + pasteable(m.rapid_at));
  std::string uncut = "-", surface = "-";
  if (is_covered_by_passes(options)) {
    const Coverage c = CoverProof(options, outcome.part, outcome.plan.path, proof).cover(kSurfacePoints);
    uncut = grouped(static_cast<double>(c.uncut)), surface = grouped(static_cast<double>(c.points));
    if (c.uncut > 0) faults.push_back("uncut near " + to_string(c.worst_at));
  }
  std::string verdict = faults.empty() ? "within" : "OVER:";
  for (const std::string& fault : faults) verdict.append(" ").append(fault).append(";");
  return {name_of(options.axis.mode),
          grouped(static_cast<double>(s.facets)),
          grouped(static_cast<double>(s.envelope_points)),
          grouped(static_cast<double>(s.points)),
          formatted("%.2f", s.seconds),
          formatted("%.2f", s.processor_seconds),
          formatted("%.0f", 1e9 * s.processor_seconds / static_cast<double>(s.facets + s.envelope_points)),
          "-",  // what it is of the tyre's, which this process does not know
          formatted("%.0f", static_cast<double>(s.peak_bytes) / (1 << 20)),
          formatted("%g", options.tolerance),
          formatted("%.4f", m.gouge),
          formatted("%.4f", m.contact),
          formatted("%.4f", m.rapid_overlap),
          uncut,
          surface,
          grouped(static_cast<double>(s.warnings)),
          verdict};
}

std::vector<std::string> refused(const std::string& why, const std::string& axis) {
  std::vector<std::string> cells(heads().size() - 1, "-");
  cells.front() = axis;
  std::string message = why.substr(0, kLongestMessage);
  std::replace(message.begin(), message.end(), '|', '/');
  std::replace(message.begin(), message.end(), '\n', ' ');
  cells.back() = message;
  return cells;
}

/// One job in this process: the cells of its row, one a line.
int serve_one(const std::string& job_path, const std::string& stl) {
  Workload work;
  work.job = job_path, work.stl = stl;
  const auto job = load(work);
  std::vector<std::string> cells;
  if (!job) {
    cells = refused(job.error().message, "-");
  } else {
    const auto outcome = stl_to_path(*job, 0);
    cells = outcome ? proven(*job, *outcome) : refused(outcome.error().message, name_of(job->plan.axis.mode));
  }
  for (const std::string& cell : cells) std::cout << cell << '\n';
  return std::cout.flush() ? 0 : 1;
}

/// The file that the job is to be planned from, or none with the reason.
Result<std::string> model_of(const std::string& job_path, const std::string& folder) {
  if (!std::filesystem::exists(job_path)) return fail(Code::kIo, job_path + " is absent");
  const std::string part = std::filesystem::path(job_path).stem().string();
  if (const auto job = load_job(job_path)) {
    if (std::filesystem::exists(job->stl_path)) return job->stl_path;
    if (auto made = part_file(folder, part)) return made;
    return fail(Code::kIo, job->stl_path + " is absent");
  }
  return std::string();  // the row says what is wrong with the job
}

/// Puts what each of a row's facets and points costs, over what the tyre's do, into the row; true if that is
/// too much. `measure`: of the tyre, ns; 0 until its row has come.
bool costs_too_much(std::vector<std::string>& cells, double& measure) {
  const auto column = [](const char* head) {
    return static_cast<std::size_t>(std::find(heads().begin(), heads().end(), head) - heads().begin());
  };
  const std::string& each = cells[column("ns each")];
  if (each == "-") return false;
  const double ns = std::stod(each);
  if (cells.front() == kMeasure) measure = ns;
  if (measure == 0.0) return false;
  cells[column("times")] = formatted("%.1f", ns / measure);
  return ns > kMostTimes * measure;
}

int table_of(const std::vector<std::string>& jobs, const std::string& folder, const std::string& markdown) {
  MarkdownTable table(heads());
  std::size_t within = 0, costly = 0;
  double measure = 0.0;
  for (const std::string& path : jobs) {
    const std::string name = std::filesystem::path(path).stem().string();
    const auto stl = model_of(path, folder);
    if (!stl) {
      std::printf("skipped %s: %s\n", name.c_str(), stl.error().message.c_str());
      continue;
    }
    const auto text = run_apart({kServe, path, *stl});
    std::vector<std::string> cells{name};
    std::istringstream lines(text ? *text : "");
    for (std::string line; std::getline(lines, line);) cells.push_back(line);
    if (cells.size() != heads().size()) {
      cells = refused(text ? "its process printed no row" : text.error().message, "-");
      cells.insert(cells.begin(), name);
    }
    costly += costs_too_much(cells, measure) ? 1 : 0;
    within += cells.back() == "within" ? 1 : 0;
    std::printf("%s: %s\n", name.c_str(), cells.back().c_str());
    std::fflush(stdout);
    table.add(std::move(cells));
  }
  const std::string text = table.text() + "\n" + std::to_string(within) + " of " +
                           std::to_string(table.size()) +
                           " within their tolerance in gouge, contact, rapids and cover; " +
                           std::to_string(costly) + " cost more than " + formatted("%g", kMostTimes) +
                           " times the tyre for each facet and envelope point.\n";
  std::printf("\n%s", text.c_str());
  const int status = costly == 0 ? 0 : 1;
  if (markdown.empty()) return status;
  const auto written = write_file(markdown, text);
  if (!written) std::fprintf(stderr, "models_table: %s\n", written.error().message.c_str());
  return written ? status : 1;
}

}  // namespace
}  // namespace tiltfeed::bench

int main(int argc, char** argv) {
  using namespace tiltfeed::bench;
  std::vector<std::string> words(argv + 1, argv + argc), jobs;
  if (words.size() == 3 && words[0] == kServe) return serve_one(words[1], words[2]);
  std::string folder = "bench", markdown;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--folder" && i + 1 < words.size())
      folder = words[++i];
    else if (words[i] == "--markdown" && i + 1 < words.size())
      markdown = words[++i];
    else
      jobs.push_back(words[i]);
  }
  return table_of(jobs, folder, markdown);
}
