#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/path_check/path_check.h"

namespace tiltfeed::sim {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity: what was never reached is null.
Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_of(const Extreme& e) {
  Json json{{"value", number_or_null(e.value)}};
  const TracePlace& p = e.place;
  if (p.block > 0) json["block"] = p.block, json["line"] = p.line;
  if (e.value > 0.0) {
    json["planned_move"] = p.move;
    if (p.facet != kNoFacet) json["facet"] = p.facet;
    json["tip_mm"] = {p.tip.x, p.tip.y, p.tip.z};
  }
  return json;
}

}  // namespace

std::string to_json(const PathCheckReport& r) {
  Json json;
  json["passed"] = r.passed();
  json["failures"] = r.failures;
  json["tolerance_mm"] = r.tolerance;
  json["axis_tolerance_deg"] = r.axis_tolerance;
  json["program"] = {{"blocks", r.program.blocks},   {"executed", r.program.executed},
                     {"missing", r.program.missing}, {"repeated", r.program.repeated},
                     {"altered", r.program.altered}, {"first_difference", r.program.first_difference}};
  json["tip_deviation_mm"] = json_of(r.tip_deviation);
  json["axis_deviation_deg"] = json_of(r.axis_deviation);
  json["missed_point_mm"] = json_of(r.missed_point);
  json["rapid_deviation_mm"] = json_of(r.rapid_deviation);
  json["gouge_mm"] = json_of(r.gouge);
  for (std::size_t i = 0; i < r.gouge_by.size(); ++i)
    json["gouge_by_mm"][kToolPartNames[i]] = json_of(r.gouge_by[i]);
  json["rapid_overlap_mm"] = json_of(r.rapid_overlap);
  json["gap_mm"] = json_of(r.gap);
  json["drop_mm"] = json_of(r.drop);
  json["drop_999_mm"] = number_or_null(r.drop_999);
  json["samples"] = r.samples;
  json["cut_samples"] = r.cut_samples;
  json["air_samples"] = r.air_samples;
  json["machine_time_s"] = r.seconds;
  json["axis_peak_speed_per_min"] = r.peaks.speed;
  json["axis_peak_acceleration_per_s2"] = r.peaks.acceleration;
  json["cut_length_mm"] = r.cut_length;
  json["plunge_length_mm"] = r.plunge_length;
  json["rapid_length_mm"] = r.rapid_length;
  return json.dump(2, ' ', true, Json::error_handler_t::replace) + "\n";
}

}  // namespace tiltfeed::sim
