#include "daemon/plan/plan_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/plan/feed_report.h"
#include "daemon/plan/formatted.h"

namespace tiltfeed::daemon {

namespace {

nlohmann::ordered_json joints_json(const Joints& j) {
  return {{"x", j.x}, {"y", j.y}, {"z", j.z}, {"a", j.a}, {"c", j.c}};
}

nlohmann::ordered_json bounds_json(const LowerBounds& bounds) {
  return {{"path_at_feed_seconds", bounds.path},
          {"axes_at_speed_seconds", joints_json(bounds.axes)},
          {"blocks_seconds", bounds.blocks}};
}

nlohmann::ordered_json starvation_json(const Starvation& s) {
  if (s.count == 0) return nullptr;
  return {{"waits_seconds", s.waits},
          {"first_block", s.first + 1},
          {"blocks", s.count},
          {"seconds", s.seconds},
          {"needed_bytes_per_s", s.bytes_per_s}};
}

nlohmann::ordered_json between_json(const pathgen::BetweenPasses& between) {
  nlohmann::ordered_json json = {{"limit_mm", between.limit},
                                 {"most_mm", between.most},
                                 {"never_cut", between.never},
                                 {"area_over_mm2", between.area},
                                 {"walls_over_mm3", between.walls},
                                 {"facet", nullptr},
                                 {"place_mm", nullptr}};
  if (between.facet != kNoFacet) {
    json["facet"] = between.facet;
    json["place_mm"] = {between.place.x, between.place.y, between.place.z};
  }
  return json;
}

nlohmann::ordered_json fixtures_json(const std::vector<pathgen::KeptByFixture>& fixtures) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const pathgen::KeptByFixture& kept : fixtures)
    json.push_back({{"name", kept.name},
                    {"points_left_out", kept.points},
                    {"area_mm2", kept.area},
                    {"place_mm", {kept.place.x, kept.place.y, kept.place.z}}});
  return json;
}

nlohmann::ordered_json uncut_json(const pathgen::RestReport& uncut) {
  nlohmann::ordered_json json = {
      {"area_mm2", uncut.area}, {"facing_area_mm2", uncut.facing_area}, {"facets_turned_away", uncut.away}};
  json["between_passes"] = between_json(uncut.between);
  json["facets"] = nlohmann::ordered_json::array();
  for (const pathgen::RestFacet& f : uncut.facets)
    json["facets"].push_back({{"facet", f.facet}, {"why", pathgen::word_of(f.why)}, {"share", f.share}});
  return json;
}

nlohmann::ordered_json free_json(const pathgen::FreeReport& free) {
  nlohmann::ordered_json json = {
      {"cl_points", free.cl_points},    {"directions_tested", free.directions},
      {"cl_length_mm", free.cl_length}, {"unreached_length_mm", free.unreached_length},
      {"breaks", free.breaks},          {"short_links", free.short_links}};
  json["unreached_facets"] = nlohmann::ordered_json::array();
  for (const pathgen::FreeReport::Facet& f : free.unreached)
    json["unreached_facets"].push_back({{"facet", f.facet}, {"why", pathgen::word_of(f.why)}});
  return json;
}

nlohmann::ordered_json indexed_json(const pathgen::IndexedReport& indexed) {
  nlohmann::ordered_json json = {{"reached_percent", 100.0 * indexed.reached},
                                 {"reachable_percent", 100.0 * indexed.reachable}};
  json["directions"] = nlohmann::ordered_json::array();
  for (const pathgen::IndexedReport::Direction& d : indexed.directions)
    json["directions"].push_back(
        {{"axis", {d.axis.x, d.axis.y, d.axis.z}}, {"alone_percent", 100.0 * d.alone}});
  return json;
}

nlohmann::ordered_json model_json(const pathgen::PartModel& model) {
  std::vector<std::string> bodies;
  for (const pathgen::PartBody& body : model.bodies) bodies.push_back(body.name);
  return {{"format", model.format},
          {"unit", model.unit},
          {"unit_mm", model.unit_mm},
          {"bodies", bodies},
          {"faces", model.faces.size()},
          {"allowed_deviation_mm", model.allowed},
          {"largest_deviation_mm", model.deviation}};
}

nlohmann::ordered_json contact_json(const pathgen::StockContact& found) {
  if (found.places == 0) return nullptr;
  return {{"depth_mm", found.depth},
          {"places", found.places},
          {"length_mm", found.length},
          {"tip_mm", {found.at.tip.x, found.at.tip.y, found.at.tip.z}},
          {"axis", {found.at.axis.x, found.at.axis.y, found.at.axis.z}}};
}

nlohmann::ordered_json stock_json(const std::optional<pathgen::StockOnCuts>& found) {
  if (!found) return nullptr;
  return {{"lines_apart_mm", found->apart},
          {"not_told_mm", found->touch},
          {"shank", contact_json(found->shank)},
          {"holder", contact_json(found->holder)}};
}

}  // namespace

double whole_tolerance(const config::Job& job) { return job.plan.tolerance + job.program.arc_tolerance; }

double rotary_turns(const JointPathReport& joints) { return (joints.max.c - joints.min.c) / 360.0; }

Starvation starved(const Timing& timing, const config::MachineProfile& machine,
                   const ProgramReport& program) {
  if (machine.link_rate <= 0.0 || program.blocks == 0) return {};
  const double bytes = static_cast<double>(program.bytes) / static_cast<double>(program.blocks);
  return starvation(timing.durations,
                    {machine.link_rate, bytes, static_cast<double>(machine.receive_buffer)});
}

namespace {

/// What an operation's path is and leaves.
void add_path(nlohmann::ordered_json& json, const OperationPlan& one) {
  const pathgen::PlanReport& plan = one.plan_report();
  json["passes"] = plan.passes;
  json["slice_points"] = plan.slice_points;
  json["points"] = plan.points;
  json["retracts"] = plan.retracts;
  json["joins"] = plan.joins;
  json["closed_rows"] = plan.closed_rows;
  json["cut_length_mm"] = plan.cut_length;
  json["rapid_length_mm"] = plan.rapid_length;
  if (plan.ridge > 0.0) json["ridge_allowed_mm"] = plan.ridge;
  if (plan.lean)
    json["lean"] = {{"length_mm", plan.lean->length},
                    {"left_mm", plan.lean->left},
                    {"largest_deg", plan.lean->largest.degrees()}};
}

/// Where the minutes go.
nlohmann::ordered_json motion_json(const TimeByMotion& t) {
  return {{"cuts_at_feed_seconds", t.cuts_at_feed},
          {"slow_axes_seconds", t.slow_axes},
          {"accelerations_seconds", t.accelerations},
          {"plunges_seconds", t.plunges},
          {"rapids_seconds", t.rapids},
          {"swings_seconds", t.swings}};
}

/// What the machine is asked for.
void add_motion(nlohmann::ordered_json& json, const Timing& timing) {
  json["machining_seconds"] = timing.seconds;
  json["slowed_blocks"] = timing.slowed;
  json["peak_velocity_per_min"] = joints_json(timing.peak_velocity);
  json["peak_acceleration_per_s2"] = joints_json(timing.peak_acceleration);
}

void add_joints(nlohmann::ordered_json& json, const OperationPlan& one) {
  const JointPathReport& joints = one.joints().report;
  const SingularityBendReport& bend = one.bend();
  json["programmed_seconds"] = joints.seconds;
  json["lower_bounds"] = bounds_json(one.bounds());
  json["time_by_motion"] = motion_json(one.by_motion());
  json["reconfigurations"] = joints.reconfigurations;
  json["pole_swings"] = joints.pole_swings;
  if (one.job().axis_tolerance.radians() > 0.0)
    json["pole_bend"] = {{"pieces", bend.stretches},
                         {"points", bend.points},
                         {"largest_deg", bend.largest.degrees()},
                         {"refused_pieces", bend.refused}};
  if (one.job().calm.radians() > 0.0)
    json["calm"] = {{"points", one.calm().points},
                    {"largest_deg", one.calm().largest.degrees()},
                    {"narrowed_moves", one.calm().refused}};
  json["rotary_turns"] = rotary_turns(joints);
  json["start_height_mm"] = nullptr;
  if (one.turn()) json["start_height_mm"] = one.turn()->height;
  json["subdivided_moves"] = joints.subdivided_moves;
  json["max_tip_deviation_mm"] = joints.max_tip_deviation;
  json["max_axis_deviation_deg"] = joints.max_axis_deviation;
  json["travel_min"] = joints_json(joints.min);
  json["travel_max"] = joints_json(joints.max);
}

void add_findings(nlohmann::ordered_json& json, const OperationPlan& one) {
  const pathgen::PlanReport& plan = one.plan_report();
  if (plan.free) json["free"] = free_json(*plan.free);
  if (plan.indexed) json["indexed"] = indexed_json(*plan.indexed);
  if (plan.rest)
    json["rest"] = {{"more_than_mm", plan.rest->more_than},
                    {"area_before_mm2", plan.rest->area},
                    {"most_left_before_mm", plan.rest->most},
                    {"all_cut", plan.rest->all_cut}};
  if (plan.uncut) json["uncut"] = uncut_json(*plan.uncut);
  if (plan.between) json["between_passes"] = between_json(*plan.between);
  json["stock_on_cuts"] = stock_json(one.stock_on_cuts());
  if (one.job().plan.fixtures) json["fixtures"] = fixtures_json(plan.fixtures);
  json["warnings"] = plan.warnings;
}

nlohmann::ordered_json shortened_json(const PlanOutcome& o) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < o.shortened.size(); ++i) {
    const ShortenedOperation& one = o.shortened[i];
    nlohmann::ordered_json json = {{"seconds_before", one.seconds},
                                   {"seconds", o.operations[i]->timing().seconds},
                                   {"plans_tried", one.tried},
                                   {"angle_deg", nullptr}};
    if (one.pattern) json["angle_deg"] = one.pattern->angle.degrees();
    if (one.frame) {
      const auto vector_json = [](Vec3 v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
      json["along"] = "x", json["t"] = vector_json(one.frame->t), json["n"] = vector_json(one.frame->n);
    }
    if (one.pattern && one.pattern->measure == pathgen::StepMeasure::kRidge)
      json["measure"] = "ridge", json["scallop_mm"] = one.pattern->scallop,
      json["join_distance_mm"] = one.join_distance;
    if (one.rounds > 0) json["rounds"] = one.rounds;
    if (one.calm.radians() > 0.0) json["calm_deg"] = one.calm.degrees();
    all.push_back(std::move(json));
  }
  return all;
}

nlohmann::ordered_json operation_json(const OperationPlan& one) {
  nlohmann::ordered_json json = {{"name", one.job().operation.name},
                                 {"tool", one.job().program.tool},
                                 {"tolerance_mm", whole_tolerance(one.job())},
                                 {"blocks", one.joints().moves.size()}};
  add_path(json, one);
  add_motion(json, one.timing());
  add_joints(json, one);
  add_findings(json, one);
  return json;
}

/// What was changed to keep bodies apart; null: nothing.
nlohmann::ordered_json avoidance_json(const PlanOutcome& o) {
  if (!o.avoidance) return nullptr;
  nlohmann::ordered_json json = {{"collision", o.avoidance->collision},
                                 {"tilt_on_other_side", o.avoidance->other_side},
                                 {"attempts", o.avoidance->attempts},
                                 {"links", nlohmann::ordered_json::array()}};
  constexpr std::array kTurns{"on_the_way", "behind", "before"};
  for (const AvoidedLink& one : o.avoidance->links)
    json["links"].push_back({{"operation", one.operation},
                             {"link", one.link},
                             {"higher_mm", one.choice.higher},
                             {"at_feed", one.choice.at_feed},
                             {"turn", kTurns[static_cast<std::size_t>(one.choice.turn)]},
                             {"at_retract", one.choice.at_retract}});
  constexpr std::array kOrders{"together", "tilt_first", "rotary_first", "over_home"};
  json["swings"] = nlohmann::ordered_json::array();
  for (const AvoidedSwing& one : o.avoidance->swings)
    json["swings"].push_back({{"operation", one.operation},
                              {"link", one.link},
                              {"order", kOrders[static_cast<std::size_t>(one.choice.way.order)]},
                              {"across_first", one.choice.way.across_first},
                              {"tilt_on_other_side", one.choice.other_side},
                              {"other_way_round", one.choice.other_way}});
  return json;
}

}  // namespace

std::string report_json(const PlanOutcome& o) {
  const OperationPlan& first = *o.operations.front();
  const bool several = !first.job().operation.name.empty();
  nlohmann::ordered_json json;
  json["part"] = first.job().plan.name;
  json["machine"] = first.job().machine.model.name;
  json["facets"] = first.plan_report().facets;
  const Vec3 size = o.part.bounds.max - o.part.bounds.min;
  json["part_size_mm"] = {size.x, size.y, size.z};
  json["part_volume_mm3"] = o.part.volume;
  if (!o.model.format.empty()) json["part_file"] = model_json(o.model);
  if (!several) add_path(json, first);
  json["blocks"] = o.program.blocks;
  json["program_bytes"] = o.program.bytes;
  json["clamped_feeds"] = o.program.clamped_feeds;
  json["tilted_planes"] = o.program.planes;
  json["plane_offsets"] = nlohmann::ordered_json::array();
  for (const PlaneOffset& plane : o.program.plane_offsets)
    json["plane_offsets"].push_back(
        {{"work_offset", plane.offset}, {"tilt_deg", plane.tilt}, {"rotary_deg", plane.rotary}});
  json["arcs"] = o.program.arcs;
  json["blocks_saved_by_arcs"] = o.program.arcs_stand_for - o.program.arcs;
  add_motion(json, o.timing);
  if (!several) add_joints(json, first);
  json["starvation"] = starvation_json(o.starved);
  json["proof"] = nullptr;
  if (o.proof)
    json["proof"] = {
        {"moves", o.proof->moves}, {"largest_gouge_mm", o.proof->gouge}, {"collisions", o.proof->collisions}};
  json["avoidance"] = avoidance_json(o);
  json["defects"] = nlohmann::ordered_json::array();
  for (const pathgen::Defect& d : o.part.defects)
    json["defects"].push_back({{"kind", to_string(d.kind)}, {"count", d.count}, {"first", d.first}});
  if (!several) add_findings(json, first);
  if (several)
    for (const OperationPlan* one : o.operations) json["operations"].push_back(operation_json(*one));
  if (!o.shortened.empty()) json["shortest_time"] = shortened_json(o);
  if (!o.feeds.empty())
    json["feed_by_engagement"] = nlohmann::ordered_json::parse(feeds_json(o.feeds, o.operations));
  json["stages"] = nlohmann::ordered_json::object();
  double wall = 0.0;
  for (const pathgen::StageTime& t : o.times)
    json["stages"][t.stage + "_seconds"] = t.seconds, wall += t.seconds;
  json["wall_seconds"] = wall;
  json["cpu_seconds"] = o.cpu_seconds;
  json["peak_memory_mb"] = o.peak_memory_mb;
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace tiltfeed::daemon
