#include "daemon/plan/suggestion_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/enum_words.h"
#include "daemon/plan/formatted.h"
#include "daemon/plan/part_size.h"
#include "kinematics/machine/machine.h"
#include "pathgen/suggest/placements.h"

namespace tiltfeed::daemon {

namespace {

using Json = nlohmann::ordered_json;

/// What is not reached is told down to this share, and so many reasons.
constexpr double kTold = 0.0005;
constexpr std::size_t kMostReasons = 3;
/// A new job's side step as a share of the cutter's diameter, and its tolerance at most and as a share.
constexpr double kStepShare = 0.1, kTolerance = 0.01, kToleranceShare = 0.005;
/// Clearance, mm, and of the room to the point, line or circle in inside work.
constexpr double kClearance = pathgen::kProposedClearance, kOfRoom = 0.2, kLeastClearance = 0.2,
                 kApproach = 1.0;

bool is_field(const pathgen::AxisFrame& axis) {
  return axis.mode != pathgen::AxisMode::kFree && axis.mode != pathgen::AxisMode::kIndexed;
}

std::string place_text(const pathgen::AxisFrame& axis) {
  if (!is_field(axis)) return "";
  const Vec3 a = pathgen::axis_of(axis);
  const auto number = [](double v) { return number_text(std::abs(v) < 5e-5 ? 0.0 : v); };
  std::string text;
  if (axis.mode != pathgen::AxisMode::kFixed)
    text = "at " + number(axis.origin.x) + " " + number(axis.origin.y) + " " + number(axis.origin.z);
  if (axis.mode == pathgen::AxisMode::kCircle) text += " radius " + number(axis.circle_radius);
  if (axis.mode != pathgen::AxisMode::kPoint)
    text +=
        std::string(text.empty() ? "" : " ") + "along " + number(a.x) + " " + number(a.y) + " " + number(a.z);
  return text;
}

/// The reasons for what is not cut, the largest first.
std::vector<pathgen::Reach> reasons(const pathgen::ReachMap& map) {
  std::vector<pathgen::Reach> found;
  for (std::size_t i = 1; i < pathgen::kReaches; ++i)
    if (map.share(static_cast<pathgen::Reach>(i)) >= kTold) found.push_back(static_cast<pathgen::Reach>(i));
  std::stable_sort(found.begin(), found.end(),
                   [&](pathgen::Reach a, pathgen::Reach b) { return map.share(a) > map.share(b); });
  return found;
}

Json vector_json(Vec3 v) { return {v.x + 0.0, v.y + 0.0, v.z + 0.0}; }

Json proposal_json(const pathgen::Proposal& p) {
  Json json = {{"mode", config::word(config::kModeWords, p.axis.mode)}};
  if (is_field(p.axis)) {
    if (p.axis.mode != pathgen::AxisMode::kFixed)
      json["sense"] = config::word(config::kSenseWords, p.axis.sense);
    json["origin_mm"] = vector_json(from_origin(p.axis.origin));
    json["t"] = vector_json(p.axis.t), json["n"] = vector_json(p.axis.n);
    if (p.axis.mode == pathgen::AxisMode::kCircle) json["circle_radius_mm"] = p.axis.circle_radius;
  }
  if (!p.directions.empty()) {
    json["directions"] = Json::array();
    for (const Vec3 d : p.directions) json["directions"].push_back(vector_json(d));
  }
  json["source"] = p.source;
  if (p.source == "fitted") json["fit_rms_mm"] = p.rms;
  json["reached_percent"] = 100.0 * p.share();
  json["shaped_percent"] = 100.0 * p.shaped;
  json["rest_percent"] = Json::object();
  for (const pathgen::Reach r : reasons(p.reach))
    json["rest_percent"][pathgen::word_of(r)] = 100.0 * p.reach.share(r);
  json["setup"] = {{"part_zero_mm", vector_json(p.setup.part_zero)},
                   {"fixture_rotation_deg", vector_json(p.fixture_deg)}};
  return json;
}

}  // namespace

std::string suggestion_text(const SuggestionOutcome& o) {
  std::string text = size_text(o.part.bounds) + ", " + std::to_string(o.part.mesh.facets.size()) +
                     " facets; cutter {" + o.cutter.text + "}; " +
                     (o.machine != nullptr ? "machine " + o.machine->model.name
                                           : std::string("no machine named: nothing limits the axis")) +
                     "\n";
  text += " #  mode     sense    reached  of shaped  set-up\n";
  for (std::size_t i = 0; i < o.found.proposals.size(); ++i) {
    const pathgen::Proposal& p = o.found.proposals[i];
    const bool sense = is_field(p.axis) && p.axis.mode != pathgen::AxisMode::kFixed;
    text += formatted(
        "%2zu  %-8s %-8s %5.1f %%    %5.1f %%  ", i + 1, config::word(config::kModeWords, p.axis.mode),
        sense ? config::word(config::kSenseWords, p.axis.sense) : "", 100.0 * p.share(), 100.0 * p.shaped);
    std::string place = place_text(p.axis);
    if (!p.directions.empty()) place = std::to_string(p.directions.size()) + " directions";
    if (o.machine != nullptr && !(p.fixture_deg == Vec3{}))
      place += formatted("%sturned %.4g %.4g %.4g on the table", place.empty() ? "" : ", ",
                         p.fixture_deg.x + 0.0, p.fixture_deg.y + 0.0, p.fixture_deg.z + 0.0);
    text += (place.empty() ? std::string("as it lies") : place) + " (" + p.source + ")\n";
    const std::vector<pathgen::Reach> why = reasons(p.reach);
    for (std::size_t k = 0; k < std::min(why.size(), kMostReasons); ++k)
      text += formatted("%s%.1f %% %s", k == 0 ? "                     rest: " : ", ",
                        100.0 * p.reach.share(why[k]), pathgen::meaning(why[k]));
    if (!why.empty()) text += "\n";
  }
  return text + formatted(
                    "reached: share of the whole surface; of shaped: without large planes and cylinders, "
                    "which many set-ups "
                    "cut. %zu placements tried, %zu places of the surface asked, %.1f s\n",
                    o.found.tried, o.found.places, o.seconds);
}

std::string suggestion_json(const SuggestionOutcome& o) {
  const Vec3 size = o.part.bounds.max - o.part.bounds.min;
  Json json = {{"stl", o.stl},
               {"size_mm", vector_json(size)},
               {"facets", o.part.mesh.facets.size()},
               {"cutter", o.cutter.text},
               {"machine", nullptr},
               {"warnings", o.part.warnings}};
  if (o.machine != nullptr) json["machine"] = o.machine->model.name;
  json["features"] = Json::array();
  for (const pathgen::Feature& f : o.found.features) {
    json["features"].push_back({{"mode", config::word(config::kModeWords, f.mode)},
                                {"centre_mm", vector_json(from_origin(f.centre))},
                                {"axis", vector_json(f.axis)},
                                {"radius_mm", f.radius},
                                {"share_percent", 100.0 * f.share},
                                {"rms_mm", f.rms}});
  }
  json["proposals"] = Json::array();
  for (std::size_t i = 0; i < o.found.proposals.size(); ++i) {
    Json proposal = proposal_json(o.found.proposals[i]);
    if (o.machine != nullptr) {
      proposal["edits"] = Json::array();
      for (const config::YamlEdit& edit : config::placement_edits(job_of(o, i, "job.yaml")))
        proposal["edits"].push_back({{"key", edit.path}, {"value", edit.value ? Json(*edit.value) : Json()}});
    }
    json["proposals"].push_back(std::move(proposal));
  }
  json["placements_tried"] = o.found.tried, json["seconds"] = o.seconds;
  return json.dump(2, ' ', true, Json::error_handler_t::replace) + "\n";
}

config::NewJob job_of(const SuggestionOutcome& o, std::size_t index, const std::string& path) {
  namespace fs = std::filesystem;
  const pathgen::Proposal& p = o.found.proposals[index];
  const fs::path folder = fs::absolute(path).parent_path();
  const auto named = [&](const std::string& file) {
    return fs::absolute(file).lexically_proximate(folder).string();
  };
  config::NewJob job;
  job.name = config::job_name_of(o.stl), job.stl = named(o.stl), job.machine = named(o.machine->path);
  job.stl_unit_mm = o.stl_unit_mm, job.cutter = o.cutter.text, job.axis = p.axis;
  const double diameter = o.cutter.cutter.diameter;
  job.side_step = kStepShare * diameter;
  job.tolerance = std::min(kTolerance, std::max(1e-4, kToleranceShare * diameter));
  job.clearance = kClearance;
  if (is_field(p.axis) && p.axis.mode != pathgen::AxisMode::kFixed &&
      p.axis.sense == pathgen::Sense::kInward) {
    const pathgen::Deformation map(p.axis, 1.0);
    double room = kClearance / kOfRoom;
    for (const Point<Part> v : o.part.mesh.vertices) room = std::min(room, map.distances(v).rho);
    job.clearance = std::max(kLeastClearance, std::floor(10.0 * kOfRoom * (room - diameter)) / 10.0);
  }
  job.approach = std::min(kApproach, job.clearance);
  job.part_zero = p.setup.part_zero, job.fixture_deg = p.fixture_deg,
  job.tilt_max = pathgen::tilt_limit(o.machine->model);
  job.remarks = {
      formatted("Proposed by tiltfeed suggest: reaches %.1f %% of the surface (%.1f %% of what is shaped).",
                100.0 * p.share(), 100.0 * p.shaped)};
  for (const pathgen::Reach r : reasons(p.reach))
    job.remarks.push_back(formatted("%.1f %% %s.", 100.0 * p.reach.share(r), pathgen::meaning(r)));
  job.remarks.push_back(
      "Check part_zero_mm against the table, clamps and head: of these nothing is known here.");
  return job;
}

}  // namespace tiltfeed::daemon
