#include "daemon/command/shop_view.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

ordered_json machine_json(const ShopMachine& one) {
  ordered_json usage = ordered_json::array();
  for (const ShopUsage& part : one.usage)
    usage.push_back({{"state", part.state}, {"day", std::round(part.day)}, {"week", std::round(part.week)}});
  return {{"id", one.id},
          {"name", one.name},
          {"profile", one.offer.profile},
          {"status", one.status},
          {"silent_seconds", one.silent_seconds},
          {"seen", one.seen},
          {"heard", one.is_heard()},
          {"back", one.back},
          {"away", one.away},
          {"live", ordered_json::parse(live_json(one.live))},
          {"usage", usage}};
}

ordered_json entry_json(const ShopEntry& one) {
  return {{"job", one.number},          {"id", one.id},
          {"name", one.name},           {"state", one.state},
          {"note", one.note},           {"machine", one.machine},
          {"program", one.program},     {"needs", one.needs},
          {"blocks", one.blocks},       {"executed", one.executed},
          {"submitted", one.submitted}, {"changed", one.changed},
          {"fits_one", one.fits_one},   {"why_not", one.why_not}};
}

ordered_json plan_json(const ShopPlan& one) {
  return {{"id", one.id},       {"name", one.name},       {"for", one.asker},   {"by", one.helper},
          {"state", one.state}, {"percent", one.percent}, {"stage", one.stage}, {"asked", one.asked}};
}

std::string plan_line(const ShopPlan& one) {
  std::string how = "waits for an idle machine";
  if (one.state == "taken")
    how = "planned by " + one.helper + ", " + std::to_string(one.percent) + " %" +
          (one.stage.empty() ? "" : " (" + one.stage + ")");
  if (one.state == "done") how = "planned by " + one.helper + ", not taken yet";
  if (one.state == "failed") how = one.helper + " has no plan of it";
  return "  " + one.name + " for " + one.asker + ": " + how + "\n";
}

}  // namespace

void add_usage(const std::map<std::string, std::vector<ShopUsage>>& usage, ShopView& view) {
  for (ShopMachine& one : view.machines)
    if (const auto found = usage.find(one.id); found != usage.end()) one.usage = found->second;
}

std::string view_json(const ShopView& view) {
  ordered_json json = {{"ok", true}, {"now", view.now}, {"epoch", view.epoch}, {"halted", view.halted}};
  json["machines"] = ordered_json::array();
  for (const ShopMachine& one : view.machines) json["machines"].push_back(machine_json(one));
  json["jobs"] = ordered_json::array();
  for (const ShopEntry& one : view.jobs) json["jobs"].push_back(entry_json(one));
  json["plans"] = ordered_json::array();
  for (const ShopPlan& one : view.plans) json["plans"].push_back(plan_json(one));
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

std::string machine_line(const ShopMachine& one) {
  char seconds[40];
  std::snprintf(seconds, sizeof seconds, "%.0f s ago", one.silent_seconds);
  const std::string said = one.is_heard() ? one.status : "not known now; it said last: " + one.status;
  return "  " + one.name + " (" + one.id.substr(0, 8) + ")  " +
         (one.away ? std::string("left in order ") : std::string("seen ")) + seconds +
         (one.back ? "" : ", has not told its part since the database's start") +
         (one.status.empty() ? "" : ": " + said) + "\n";
}

std::string view_text(const ShopView& view) {
  std::string text =
      "epoch " + std::to_string(view.epoch) + (view.halted.empty() ? "" : ", halted: " + view.halted) + "\n";
  text += "machines:" + std::string(view.machines.empty() ? " none yet" : "") + "\n";
  for (const ShopMachine& one : view.machines) text += machine_line(one);
  text += "jobs:" + std::string(view.jobs.empty() ? " none" : "") + "\n";
  for (const ShopEntry& one : view.jobs) {
    text += "  " + std::to_string(one.number) + "  " + one.state + "  " + one.name +
            (one.machine.empty() ? "" : " at " + one.machine);
    if (one.blocks > 0)
      text += ", " + std::to_string(one.executed) + " of " + std::to_string(one.blocks) + " blocks";
    text += "  [" + one.needs + "]" + (one.note.empty() ? "" : "  (" + one.note + ")") + "\n";
    if (!one.fits_one) text += "      no machine fits: " + one.why_not + "\n";
  }
  if (!view.plans.empty()) text += "planned for each other:\n";
  for (const ShopPlan& one : view.plans) text += plan_line(one);
  return text;
}

}  // namespace tiltfeed::daemon
