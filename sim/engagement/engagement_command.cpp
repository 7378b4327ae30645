#include "sim/engagement/engagement_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <thread>
#include <vector>

#include "config/job.h"
#include "config/job_inputs.h"
#include "config/output_file.h"
#include "config/part_reading.h"
#include "sim/engagement/chip_gauge.h"
#include "sim/engagement/engagement.h"
#include "sim/engagement/engagement_plot.h"
#include "sim/engagement/engagement_table.h"
#include "sim/report/verified_moves.h"

namespace tiltfeed::sim {
namespace {

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2;
constexpr double kFinestLines = 1e-3, kCoarsestLines = 50.0;  // mm

/// Largest values of an operation, as its machine runs.
struct OperationPeaks {
  double chip = 0.0, edge_load = 0.0, turn_load = 0.0, volume = 0.0;
};

OperationPeaks peaks_of(const Engagement& engagement) {
  OperationPeaks peaks;
  for (std::size_t i = 0; i < engagement.spans.size(); ++i) {
    const EngagedSpan& span = engagement.spans[i];
    const SpanEngagement& load = engagement.loads[i];
    if (span.rapid || !(span.took > 0.0)) continue;
    const double speed = span.asked / span.took, power = std::pow(speed, kChipExponent);
    peaks.chip = std::max(peaks.chip, load.chip * speed);
    peaks.edge_load = std::max(peaks.edge_load, load.edge_load * power);
    peaks.turn_load = std::max(peaks.turn_load, load.turn_load * power);
    peaks.volume += load.volume;
  }
  return peaks;
}

class EngagementRun {
 public:
  explicit EngagementRun(const EngagementFiles& files) : files_(files) {}
  Result<void> run();

 private:
  Result<void> load();
  Result<void> measure();
  Result<void> write();
  bool show(double share) const {
    if (files_.progress) std::printf("progress %.3f\n", share), std::fflush(stdout);
    return true;
  }

  const EngagementFiles& files_;
  int threads_ = 1;
  std::vector<config::Job> jobs_;
  config::PartsByTolerance parts_;
  std::ostringstream table_;
};

Result<void> EngagementRun::load() {
  auto jobs = config::load_operations(
      files_.job, {.stl = files_.stl, .machine = files_.machine, .operation = files_.operation});
  if (!jobs) return tl::unexpected(jobs.error());
  jobs_ = std::move(*jobs);
  std::vector<config::NamedFile> inputs;
  for (const config::Job& job : jobs_)
    for (const config::NamedFile& file : config::files_of(job)) inputs.push_back(file);
  for (const auto& [name, path] :
       {std::pair{"PROGRAM", files_.program}, {"--stock", files_.stock}, {"--before", files_.before}})
    inputs.push_back({name, path});
  threads_ = files_.threads > 0 ? files_.threads
                                : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return config::check_outputs({{"--out", files_.table}, {"--plot", files_.plot}}, inputs);
}

/// Operation by operation, the stock carried on.
Result<void> EngagementRun::measure() {
  const auto part = parts_.of(jobs_.front());
  if (!part) return tl::unexpected(part.error());
  auto shape =
      files_.stock.empty() ? Result<StockShape>(default_stock(jobs_.front())) : parse_stock(files_.stock);
  if (!shape) return tl::unexpected(shape.error());
  if (files_.stock.empty() && shape->kind == StockKind::kOffset && (*part)->sides != pathgen::Sides::kOutward)
    shape = StockShape{StockKind::kBox, shape->margin, {}};
  double cell = files_.resolution.value_or(kCoarsestLines);
  if (!files_.resolution)
    for (const config::Job& job : jobs_) cell = std::min(cell, default_cell(job, **part));
  const auto moves = read_moves({Source::kProgram, files_.program}, jobs_);
  if (!moves) return tl::unexpected(moves.error());
  auto stock = make_stock(*shape, **part, jobs_.front(), cell, threads_);
  if (!stock) return tl::unexpected(stock.error());
  table_ << kEngagementColumns << "\n";
  for (std::size_t i = 0; i < jobs_.size(); ++i) {
    const ExecutedPath& path = moves->paths[i];
    const EngagementOptions options{engagement_step(jobs_[i].plan.cutter, cell), threads_};
    const auto count = static_cast<double>(jobs_.size());
    const auto found = measure_engagement(jobs_[i], path, *stock, options, [&](double share) {
      return show((static_cast<double>(i) + share) / count);
    });
    if (!found) return tl::unexpected(found.error());
    write_engagement(i + 1, path, *found, table_);
    const OperationPeaks peaks = peaks_of(*found);
    std::fprintf(files_.table == "-" || files_.plot == "-" ? stderr : stdout,
                 "operation %zu: %.3f s, removed %.1f mm3, thickest chip as in a slot at %.1f mm/min, "
                 "largest load %.5f on "
                 "an edge, %.5f over a turn\n",
                 i + 1, path.seconds, peaks.volume, peaks.chip, peaks.edge_load, peaks.turn_load);
  }
  return {};
}

Result<void> EngagementRun::write() {
  std::vector<config::OutputFile> outputs;
  const auto add = [&](const std::string& path, const std::string& bytes) -> Result<void> {
    if (path.empty()) return {};
    auto file = config::OutputFile::open(path);
    if (!file) return tl::unexpected(file.error());
    file->stream() << bytes;
    outputs.push_back(std::move(*file));
    return outputs.back().flush();
  };
  if (auto added = add(files_.table, table_.str()); !added) return added;
  if (!files_.plot.empty()) {
    const auto spans_of = [](std::istream& in) {
      std::vector<PlottedSpan> spans;
      PlottedSpan span;
      for (std::string line; std::getline(in, line);)
        if (plotted_span(line, span)) spans.push_back(span);
      return spans;
    };
    std::istringstream now(table_.str());
    std::vector<PlottedSpan> before;
    if (!files_.before.empty()) {
      std::ifstream in(files_.before);
      if (!in) return fail(Code::kIo, files_.before + ": cannot be opened");
      before = spans_of(in);
      if (before.empty())
        return fail(Code::kInput,
                    files_.before + ": no table of engagement; `tiltfeed-sim engagement --out` writes one");
    }
    if (auto added = add(files_.plot, engagement_svg(spans_of(now), before)); !added) return added;
  }
  return config::OutputFile::commit_all(outputs);
}

Result<void> EngagementRun::run() {
  for (const auto stage : {&EngagementRun::load, &EngagementRun::measure, &EngagementRun::write})
    if (auto done = (this->*stage)(); !done) return done;
  return {};
}

}  // namespace

int engagement_command(const EngagementFiles& files) {
  const auto complain = [](const Error& error) {
    std::cerr << "tiltfeed-sim engagement: " << error.message << "\n";
    return error.code == Code::kUsage ? kWrongUse : kFailed;
  };
  if (files.resolution && !(*files.resolution >= kFinestLines && *files.resolution <= kCoarsestLines))
    return complain({Code::kUsage, "--resolution is not between 0.001 and 50 mm"});
  const auto done = EngagementRun(files).run();
  return done ? kDone : complain(done.error());
}

}  // namespace tiltfeed::sim
