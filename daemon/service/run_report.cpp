#include "daemon/service/run_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

constexpr double kMilli = 1000.0;

double rounded(double seconds) { return std::round(seconds * kMilli) / kMilli; }

template <class T>
ordered_json known(const std::optional<T>& value) {
  return value ? ordered_json(*value) : ordered_json();
}

ordered_json json_of(const RunReport& run) {
  ordered_json json = {{"run", run.id},
                       {"job", run.job},
                       {"name", run.name},
                       {"sha256", run.hash},
                       {"link", run.link},
                       {"user", known(run.user)},
                       {"began", run.began},
                       {"ended", known(run.ended)},
                       {"first_block", run.first},
                       {"blocks", run.blocks},
                       {"executed", run.executed}};
  for (const char* const key : {"sent", "resends", "seconds", "holds", "held_seconds", "slowest_hold_seconds",
                                "feed_override_least", "feed_override_most", "starved_seconds"})
    json[key] = nullptr;
  if (run.figures) {
    const RunReport::Figures& f = *run.figures;
    json["sent"] = f.sent;
    json["resends"] = f.resends;
    json["seconds"] = rounded(f.seconds);
    json["holds"] = f.holds;
    json["held_seconds"] = rounded(f.held_seconds);
    if (f.starved_seconds) json["starved_seconds"] = rounded(*f.starved_seconds);
    if (f.slowest_hold) json["slowest_hold_seconds"] = rounded(*f.slowest_hold);
    if (f.feed_override) {
      json["feed_override_least"] = f.feed_override->least;
      json["feed_override_most"] = f.feed_override->most;
    }
  }
  json["outcome"] = run.outcome.empty() ? "running" : run.outcome;
  json["note"] = run.note;
  return json;
}

}  // namespace

std::string runs_json(const std::vector<RunReport>& runs) {
  ordered_json json = ordered_json::array();
  for (const RunReport& run : runs) json.push_back(json_of(run));
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

}  // namespace tiltfeed::daemon
