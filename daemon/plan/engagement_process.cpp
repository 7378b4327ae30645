#include "daemon/plan/engagement_process.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <utility>

#include "config/child_process.h"

namespace tiltfeed::daemon {
namespace {

constexpr std::string_view kFigures = "operation ", kHead = "operation,", kName = "tiltfeed-sim engagement: ";

/// What the process says, line by line.
struct HeardEngagement {
  void take(const std::string& line);
  MeasuredEngagement found;
  std::string said;  ///< what is no figure
};

void HeardEngagement::take(const std::string& line) {
  if (line.starts_with(kHead)) return;
  std::size_t operation = 0;
  double seconds = 0.0;
  if (line.starts_with(kFigures) &&
      std::sscanf(line.c_str(), "operation %zu: %lf s", &operation, &seconds) == 2) {
    found.seconds.resize(std::max(found.seconds.size(), operation));
    found.seconds[operation - 1] = seconds;
    return;
  }
  EngagedRow row;
  unsigned long long first = 0, last = 0;
  if (std::sscanf(line.c_str(), "%zu,%llu,%lf,%llu,%lf,%lf,%*f,%*f,%*f,%lf,%lf,%lf,%lf,%lf", &operation,
                  &first, &row.first_share, &last, &row.last_share, &row.way, &row.chip, &row.edge_load,
                  &row.turn_load, &row.asked, &row.took) == 11 &&
      operation > 0) {
    row.first_behind = first, row.last_behind = last;
    found.rows.resize(std::max(found.rows.size(), operation));
    found.rows[operation - 1].push_back(row);
    return;
  }
  said += (said.empty() ? "" : "\n") + line;
}

}  // namespace

Result<MeasuredEngagement> measure_engagement(const EngagementRequest& request, int program,
                                              const StageProgress& progress) {
  const auto simulator = config::program_beside("tiltfeed-sim");
  if (!simulator) return tl::unexpected(simulator.error());
  std::vector<std::string> words{
      *simulator, "engagement", request.job, "/dev/fd/" + std::to_string(config::HeardProcess::kFile),
      "--out",    "-",          "--progress"};
  const std::pair<const char*, const std::string&> stated[] = {{"--stl", request.stl},
                                                               {"--machine", request.machine},
                                                               {"--operation", request.operation},
                                                               {"--stock", request.stock}};
  for (const auto& [option, value] : stated)
    if (!value.empty()) words.emplace_back(option), words.push_back(value);
  config::HeardProcess process;
  if (const int failed = process.start(words, program); failed != 0)
    return fail(Code::kIo,
                words.front() + ": " + std::strerror(failed) +
                    "; it measures what the cutter has to do and belongs beside tiltfeed: install both, "
                    "or leave out --optimise feed");
  HeardEngagement heard;
  if (auto ended = process.listen(progress, [&](const std::string& line) { heard.take(line); }); !ended)
    return tl::unexpected(ended.error());
  const int status = process.wait();
  if (status != 0)
    return fail(Code::kInput, "the engagement is not known, nothing was written: " +
                                  config::last_word_of(std::move(heard.said), kName, status));
  heard.found.rows.resize(heard.found.seconds.size());
  return std::move(heard.found);
}

}  // namespace tiltfeed::daemon
