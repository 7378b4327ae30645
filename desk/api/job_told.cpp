// What is told of the job.

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/description.h"
#include "config/enum_words.h"
#include "config/job_catalogue.h"
#include "desk/api/job_work.h"
#include "desk/view/part_view.h"
#include "desk/view/tool_outline.h"

namespace tiltfeed::desk {

using nlohmann::json;

std::string JobWork::unit() const {
  for (const StlUnit& unit : kStlUnits)
    if (job().stl_unit_mm == unit.mm) return unit.word;
  return config::exact_text(job().stl_unit_mm);
}

namespace {

/// Cutter, shank and holder, to draw them.
json tool_json(const pathgen::Cutter& cutter) {
  json pieces = json::array();
  for (const ToolOutline& piece : tool_outline(cutter))
    pieces.push_back({{"part", piece.part}, {"outline", piece.points}});
  return pieces;
}

/// X, Y, Z, tilt, rotary: limits of travel, speed (a minute) and acceleration (a second squared).
json axes_json(const MachineModel& m) {
  json axes = json::array();
  const auto add = [&](const char letter, const char* unit, bool present, const auto& axis) {
    axes.push_back({{"letter", std::string(1, letter)},
                    {"unit", unit},
                    {"present", present},
                    {"min", axis.min},
                    {"max", axis.max},
                    {"velocity", axis.velocity},
                    {"acceleration", axis.acceleration}});
  };
  add('X', "mm", true, m.x);
  add('Y', "mm", true, m.y);
  add('Z', "mm", true, m.z);
  add(m.tilt.letter, "degrees", m.tilt.present, m.tilt);
  add(m.rotary.letter, "degrees", m.rotary.present, m.rotary);
  return axes;
}

json cutter_json(const pathgen::Cutter& cutter) {
  return {{"diameter_mm", cutter.diameter}, {"length_mm", cutter.shank_length}, {"tool", tool_json(cutter)}};
}

json operation_json(const config::Job& job) {
  return {{"tool", job.program.tool},
          {"tool_id", job.tool_id},
          {"cutter_type", config::word(config::kCutterWords, job.plan.cutter.type)},
          {"cutter", cutter_json(job.plan.cutter)},
          {"axis", config::word(config::kModeWords, job.plan.axis.mode)},
          {"pattern", config::word(config::kKindWords, job.plan.pattern.kind)},
          {"rest_mm", job.plan.rest_more_than},
          {"place", job.operation.number}};
}

/// In the order of the list. Of an operation that is new or named anew since the text was right last only the
/// name is known.
json operations_json(const std::string& text, const std::vector<config::Job>& jobs) {
  json all = json::array();
  const auto keys = config::operation_keys(text);
  if (!keys) return all;
  for (const config::OperationKeys& one : *keys) {
    if (one.number == 0) continue;
    json told{{"name", one.name}, {"number", one.number}, {"own", one.own}};
    const auto job = std::find_if(jobs.begin(), jobs.end(),
                                  [&](const config::Job& known) { return known.operation.name == one.name; });
    if (job != jobs.end() && !one.name.empty()) told.update(operation_json(*job));
    all.push_back(std::move(told));
  }
  return all;
}

/// As it is written.
std::string order_in(const std::string& text) {
  const auto value = config::value_texts(text, {"operation_order"});
  return value && !value->front().empty() ? value->front() : "listed";
}

}  // namespace

const config::Job* JobWork::operation(const std::string& name) const {
  if (name.empty()) return &jobs_.front();
  for (const config::Job& job : jobs_)
    if (job.operation.name == name) return &job;
  return nullptr;
}

std::string JobWork::describe() const {
  if (!is_open()) return "null";
  json errors = json::array();
  for (const JobError& error : errors_)
    errors.push_back({{"line", error.line}, {"column", error.column}, {"message", error.message}});
  json about{{"id", id_},
             {"name", opened_.empty() ? std::filesystem::path(made_.part).stem().string() + ".yaml"
                                      : std::filesystem::path(opened_).filename().string()},
             {"saved", !opened_.empty() && text_ == saved_},
             {"made_here", !made_.part.empty()},
             {"can_save", !opened_.empty() || !made_.folder.empty()},
             {"errors", errors},
             {"machine", job().machine.model.name},
             {"cutter", cutter_json(job().plan.cutter)},
             {"operations", operations_json(text_, jobs_)},
             {"operation_order", order_in(text_)},
             {"bodies", job().bodies},
             {"avoid_faces", job().avoid_faces},
             {"axes", axes_json(job().machine.model)}};
  return about.dump(-1, ' ', true, json::error_handler_t::replace);
}

}  // namespace tiltfeed::desk
