#include "daemon/command/history_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string_view>

#include "config/output_file.h"
#include "daemon/command/command.h"
#include "daemon/service/api.h"
#include "daemon/service/api_socket.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::json;

/// Columns of the table for people.
constexpr int kRunWidth = 6, kTimeWidth = 21, kTakesWidth = 9, kNameWidth = 24;

/// Empty where it is not known.
std::string utc(const json& seconds) { return seconds.is_null() ? "" : utc_text(seconds.get<std::time_t>()); }

/// Midnight, UTC, of YYYY-MM-DD.
std::optional<std::time_t> day_of(const std::string& text) {
  std::tm parts{};
  const char* const end = ::strptime(text.c_str(), "%Y-%m-%d", &parts);
  if (end == nullptr || *end != 0) return std::nullopt;
  return ::timegm(&parts);
}

/// As RFC 4180 has it. A text that a spreadsheet would take for a formula gets an apostrophe.
std::string csv_field(const json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  std::string text = value.get<std::string>();
  if (!text.empty() && std::string_view("=+-@").find(text[0]) != std::string_view::npos) text.insert(0, "'");
  if (text.find_first_of(",\"\r\n") == text.npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

Result<json> ask_runs(const std::string& socket, std::uint64_t job) {
  json all = json::array();
  ApiRequest request;
  request.op = ApiOp::kHistory;
  request.job = job;
  for (bool more = true; more;) {
    const Result<std::string> line = ask_service(socket, write_request(request), {});
    if (!line) return tl::unexpected<Error>(line.error());
    const json answer = json::parse(*line, nullptr, false);
    if (!answer.is_object()) return fail(Code::kIo, socket + ": the answer is not understood");
    if (!answer.value("ok", false)) return fail(Code::kInput, answer.value("error", "refused"));
    for (const json& run : answer.at("runs"))
      all.push_back(run), request.from = run.at("run").get<std::uint64_t>();
    more = answer.value("more", false);
  }
  return all;
}

/// The columns, in the order of the service's answer.
constexpr const char* kKeys[] = {"run",
                                 "job",
                                 "name",
                                 "sha256",
                                 "link",
                                 "user",
                                 "began",
                                 "ended",
                                 "first_block",
                                 "blocks",
                                 "executed",
                                 "sent",
                                 "resends",
                                 "seconds",
                                 "holds",
                                 "held_seconds",
                                 "slowest_hold_seconds",
                                 "feed_override_least",
                                 "feed_override_most",
                                 "starved_seconds",
                                 "outcome",
                                 "note"};

std::string as_csv(const json& runs) {
  std::string out;
  for (const char* const key : kKeys) out += (key == kKeys[0] ? "" : ",") + std::string(key);
  out += "\r\n";
  for (const json& run : runs) {
    for (const std::string key : kKeys) {
      const bool time = key == "began" || key == "ended";
      out += (key == kKeys[0] ? "" : ",") + (time ? utc(run.at(key)) : csv_field(run.at(key)));
    }
    out += "\r\n";
  }
  return out;
}

void print_run(const json& run) {
  const json& seconds = run.at("seconds");
  std::ostringstream takes;
  if (!seconds.is_null()) takes << std::fixed << std::setprecision(1) << seconds.get<double>() << " s";
  std::cout << std::setw(kRunWidth) << run.at("run").get<std::uint64_t>() << "  " << std::left
            << std::setw(kTimeWidth) << utc(run.at("began")) << std::right << std::setw(kTakesWidth)
            << takes.str() << "  job " << run.at("job").get<std::uint64_t>() << " " << std::left
            << std::setw(kNameWidth) << run.at("name").get<std::string>() << std::right << " "
            << run.at("executed").get<std::uint64_t>() << " of " << run.at("blocks").get<std::uint64_t>()
            << " blocks, " << run.at("outcome").get<std::string>();
  if (!run.at("holds").is_null() && run.at("holds") != 0) std::cout << ", " << run.at("holds") << " holds";
  const std::string note = run.at("note").get<std::string>();
  if (!note.empty() && run.at("outcome") != "done") std::cout << ": " << note;
  std::cout << "\n";
}

}  // namespace

Result<std::string> last_runs(const std::string& socket, std::size_t most) {
  const Result<json> runs = ask_runs(socket, 0);
  if (!runs) return tl::unexpected<Error>(runs.error());
  std::string text;
  for (std::size_t i = runs->size() - std::min(runs->size(), most); i < runs->size(); ++i)
    text += (*runs)[i].dump(-1, ' ', true, json::error_handler_t::replace) + "\n";
  return text;
}

struct HistoryCommand::Options {
  CLI::App* history = nullptr;
  std::string socket, out = "-", since;
  std::uint64_t job = 0;
  bool as_csv = false, as_json = false;
};

HistoryCommand::HistoryCommand(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.socket = service_socket();
  o.history =
      app.add_subcommand("history", "the runs of a service's machine: who, when, what, how they ended");
  o.history->add_option("JOB", o.job, "its runs only; else those of all jobs, removed ones included")
      ->check(above_zero);
  o.history->add_option("--since", o.since, "YYYY-MM-DD: runs that began on this day (UTC) or later")
      ->check(
          [](const std::string& text) { return day_of(text) ? std::string() : text + " is no YYYY-MM-DD"; });
  o.history->add_option(
      "--socket", o.socket,
      "the service's socket (default: $TILTFEED_SOCKET, else " + std::string(kDefaultSocket) + ")");
  const auto csv = o.history->add_flag("--csv", o.as_csv, "a table for a spreadsheet; times in UTC");
  o.history->add_flag("--json", o.as_json, "print one JSON object")->excludes(csv);
  o.history->add_option("--out", o.out, "file for the CSV; else shown")->needs(csv);
}

HistoryCommand::~HistoryCommand() = default;

bool HistoryCommand::called() const { return options_->history->parsed(); }

int HistoryCommand::run() const {
  const Options& o = *options_;
  Result<json> runs = ask_runs(o.socket, o.job);
  if (!runs) return complain(runs.error());
  if (!o.since.empty())
    runs->erase(std::remove_if(runs->begin(), runs->end(),
                               [since = *day_of(o.since)](const json& run) {
                                 return run.at("began").get<std::time_t>() < since;
                               }),
                runs->end());
  if (o.as_json)
    return show_json(
        json({{"ok", true}, {"runs", *runs}}).dump(-1, ' ', true, json::error_handler_t::replace));
  if (!o.as_csv) {
    for (const json& run : *runs) print_run(run);
    return kExitDone;
  }
  const Result<void> written = config::write_file(o.out, as_csv(*runs));
  return written ? kExitDone : complain(written.error());
}

}  // namespace tiltfeed::daemon
