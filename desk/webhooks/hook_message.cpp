#include "desk/webhooks/hook_message.h"

#include <array>
#include <ctime>
#include <nlohmann/json.hpp>

#include "desk/webhooks/signature.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostText = 1000;  // bytes of a name or a reason
constexpr std::size_t kIdDigits = 32;    // 128 bits

std::string text_in(const ordered_json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>().substr(0, kMostText) : "";
}

std::uint64_t number_in(const ordered_json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

ToldRun run_of(const ordered_json& row) {
  ToldRun run;
  run.run = number_in(row, "run");
  run.job = number_in(row, "job");
  run.blocks = number_in(row, "blocks");
  run.executed = number_in(row, "executed");
  run.began = static_cast<std::int64_t>(number_in(row, "began"));
  if (const std::uint64_t ended = number_in(row, "ended"); ended > 0)
    run.ended = static_cast<std::int64_t>(ended);
  run.name = text_in(row, "name");
  run.sha256 = text_in(row, "sha256");
  run.outcome = text_in(row, "outcome");
  run.note = text_in(row, "note");
  return run;
}

/// ISO 8601, UTC.
std::string iso_time(std::int64_t seconds) {
  const std::time_t time = seconds;
  std::tm parts{};
  std::array<char, sizeof "9999999999-12-31T23:59:59Z"> text{};
  if (!::gmtime_r(&time, &parts) ||
      std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts) == 0)
    return "1970-01-01T00:00:00Z";
  return text.data();
}

ordered_json or_null(const std::string& text) { return text.empty() ? ordered_json() : ordered_json(text); }

/// What names the event for ever, and no other one.
std::string id_of(const std::string& machine, const std::string& what, std::int64_t when) {
  return sha256_digits(machine + "\n" + what + "\n" + std::to_string(when)).substr(0, kIdDigits);
}

std::string body_of(const ordered_json& json) {
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

void add_run(ordered_json& json, const std::optional<ToldRun>& run) {
  json["run"] = run ? ordered_json(run->run) : ordered_json();
  json["job"] = run ? ordered_json(run->job) : ordered_json();
  json["program"] = run ? or_null(run->name) : ordered_json();
  json["sha256"] = run ? or_null(run->sha256) : ordered_json();
  json["blocks_done"] = run ? ordered_json(run->executed) : ordered_json();
  json["blocks"] = run ? ordered_json(run->blocks) : ordered_json();
}

}  // namespace

Result<HistoryPage> read_history(const std::string& reply) {
  const ordered_json said = ordered_json::parse(reply, nullptr, false);
  const auto runs = said.is_object() ? said.find("runs") : said.end();
  if (!said.is_object() || runs == said.end() || !runs->is_array())
    return fail(Code::kIo, "the service's history is not understood");
  HistoryPage page;
  const auto more = said.find("more");
  page.more = more != said.end() && *more == true;
  for (const ordered_json& row : *runs)
    if (row.is_object() && number_in(row, "run") > 0) page.runs.push_back(run_of(row));
  return page;
}

std::optional<HookMessage> message_of(const ToldRun& run, const std::string& machine, std::int64_t seen) {
  const bool done = run.outcome == "done";
  if (run.goes_on() || run.outcome == "stopped" || run.outcome == "tool change") return std::nullopt;
  HookMessage message;
  message.fault = !done;
  message.id = id_of(machine, "run " + std::to_string(run.run) + " " + run.outcome, run.began);
  ordered_json json = {{"id", message.id},
                       {"event", done ? "done" : "fault"},
                       {"time", iso_time(run.ended.value_or(seen))},
                       {"machine", machine}};
  add_run(json, run);
  json["outcome"] = run.outcome;
  json["reason"] = or_null(run.note);
  message.body = body_of(json);
  return message;
}

HookMessage lost_message(const std::string& machine, std::int64_t since, const std::string& why,
                         const std::optional<ToldRun>& run) {
  HookMessage message{id_of(machine, "lost", since), true, {}};
  ordered_json json = {
      {"id", message.id}, {"event", "fault"}, {"time", iso_time(since)}, {"machine", machine}};
  add_run(json, run);
  json["outcome"] = "not answered";
  json["reason"] = "the machine's service does not answer: " + why;
  message.body = body_of(json);
  return message;
}

}  // namespace tiltfeed::desk
