#include "daemon/mtconnect/observations.h"

#include <nlohmann/json.hpp>

namespace tiltfeed::daemon {
namespace {

using nlohmann::json;
constexpr double kSecondsInMinute = 60.0;

/// On one line; where it has a bar it is quoted, as SHDR asks for.
std::string field(const std::string& value) {
  std::string out;
  bool barred = false;
  for (const char c : value) {
    if (c == '|') barred = true, out += '\\';
    out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return barred ? '"' + out + '"' : out;
}

std::string condition(const char* level, const std::string& code = {}, const std::string& text = {}) {
  return std::string(level) + "|" + field(code) + "|||" + field(text);
}

/// As the service wrote it: a line has no decimals.
std::string number(const json& value) { return value.is_number() ? value.dump() : kUnavailable; }

/// Of a phase of a run.
const char* execution_of(const std::string& phase) {
  if (phase == "run" || phase == "drain") return "ACTIVE";
  if (phase == "hold") return "FEED_HOLD";
  if (phase == "operator stop") return "PROGRAM_STOPPED";
  if (phase == "done") return "PROGRAM_COMPLETED";
  if (phase == "stop" || phase == "stopped") return "STOPPED";
  if (phase == "alarm" || phase == "fault") return "INTERRUPTED";
  return "READY";
}

/// Of what became of the newest run.
const char* execution_after(const std::string& outcome) {
  if (outcome == "done") return "PROGRAM_COMPLETED";
  if (outcome == "stopped" || outcome == "failed") return "STOPPED";
  if (outcome == "interrupted" || outcome == "uncertain") return "INTERRUPTED";
  if (outcome == "tool change") return "PROGRAM_STOPPED";
  return "READY";
}

/// The first line that is not surely executed; 0: not known.
std::uint64_t line_of(const json& job) {
  const json lines = job.value("uncertain_lines", json::array());
  return lines.empty() ? 0 : lines[0].get<std::uint64_t>();
}

void tell_places(const json& job, Observations& out) {
  const json program = job.value("program", json::object());
  for (const auto& [letter, place] : program.items())
    for (const std::string& id : {letter + "_position", letter + "_angle"})
      if (out.contains(id)) out[id] = number(place);
  if (program.contains("X") && program.contains("Y") && program.contains("Z"))
    out["position"] = number(program["X"]) + " " + number(program["Y"]) + " " + number(program["Z"]);
}

void tell_run(const json& job, const std::string& block, Observations& out) {
  const std::string phase = job.value("phase", ""), words = job.value("words", "");
  out["mode"] = "AUTOMATIC";
  out["execution"] = job.value("state", "") == "tool change" ? "PROGRAM_STOPPED" : execution_of(phase);
  out["program"] = field(job.value("name", ""));
  if (const std::uint64_t line = line_of(job); line > 0) out["line"] = std::to_string(line);
  if (!block.empty()) out["block"] = field(block);
  tell_places(job, out);
  const json overrides = job.value("override", json::object());
  for (const auto& [name, id] :
       {std::pair{"feed", "feed_override"}, {"rapid", "rapid_override"}, {"spindle", "S_override"}})
    if (overrides.contains(name)) out[id] = number(overrides[name]);
  if (job.contains("feed_mm_per_min"))
    out["feedrate"] = number(job["feed_mm_per_min"].get<double>() / kSecondsInMinute);
  if (job.contains("spindle_rpm")) out["S_speed"] = number(job["spindle_rpm"]);
  if (phase == "hold")
    out["motion"] = condition("WARNING", job.value("machine", ""), job.value("held", "held"));
  if (phase == "alarm") out["system"] = condition("FAULT", job.value("machine", ""), words);
  if (phase == "fault") out["comms"] = condition("FAULT", job.value("machine", ""), job.value("note", ""));
}

/// A run that did not come to its end stays a condition until the next begins.
void tell_outcome(const json& run, Observations& out) {
  const std::string outcome = run.value("outcome", "");
  const json note = run.value("note", json());
  const std::string why = note.is_string() ? note.get<std::string>() : "";
  out["execution"] = execution_after(outcome);
  if (outcome == "interrupted" || outcome == "uncertain") out["comms"] = condition("FAULT", outcome, why);
  if (outcome == "failed") out["logic"] = condition("FAULT", outcome, why);
}

}  // namespace

Result<Observations> observe(const std::vector<DataItem>& items, const std::optional<ServiceView>& view) {
  Observations out;
  for (const DataItem& item : items)
    out[item.id] = item.category != ItemCategory::kCondition ? kUnavailable
                   : view                                    ? condition("NORMAL")
                                                             : condition(kUnavailable);
  if (!view) return out;
  out["avail"] = "AVAILABLE";
  out["S_mode"] = "SPINDLE";
  out["parts"] = std::to_string(view->parts);
  out["execution"] = "READY";
  try {
    if (!view->job.empty())
      tell_run(json::parse(view->job), view->block, out);
    else if (!view->last.empty())
      tell_outcome(json::parse(view->last), out);
  } catch (const json::exception& error) {
    return fail(Code::kIo, std::string("the service's answer is not understood: ") + error.what());
  }
  return out;
}

std::string shdr_lines(const std::vector<DataItem>& items, const Observations* before,
                       const Observations& now, const std::string& time) {
  std::string values, conditions;
  for (const DataItem& item : items) {
    const std::string& value = now.at(item.id);
    if (before != nullptr && before->at(item.id) == value) continue;
    if (item.category == ItemCategory::kCondition)
      conditions += time + "|" + item.id + "|" + value + "\n";
    else
      values += "|" + item.id + "|" + value;
  }
  return (values.empty() ? "" : time + values + "\n") + conditions;
}

}  // namespace tiltfeed::daemon
