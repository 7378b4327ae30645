#include "daemon/command/tool_command.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/command/command.h"
#include "daemon/command/machine_command.h"
#include "daemon/command/service_talk.h"
#include "daemon/machine/tool_guide.h"
#include "daemon/service/api.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::json;

}  // namespace

struct ToolCommand::Options {
  CLI::App* command = nullptr;
  std::string socket;
  std::vector<std::string> words;
  bool as_json = false, yes = false;

  Result<json> ask(std::uint64_t job, const std::string& command, const std::string& said,
                   bool confirmed) const;
  int tell(const json& answer) const;
  int go(std::uint64_t job) const;
  int guide(std::uint64_t job, const json& shown) const;
};

ToolCommand::ToolCommand(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.socket = service_socket();
  o.command = app.add_subcommand(
      "tool", "the tool change that a job of the service waits for; without words, on a terminal: guided");
  o.command->add_option("WORDS", o.words, "[JOB] [show | length MM | go]");
  o.command->add_option(
      "--socket", o.socket,
      "the service's socket (default: $TILTFEED_SOCKET, else " + std::string(kDefaultSocket) + ")");
  o.command->add_flag("--yes", o.yes, "go: do not ask after showing the way back");
  o.command->add_flag("--json", o.as_json, "print one JSON object");
}

ToolCommand::~ToolCommand() = default;
bool ToolCommand::called() const { return options_->command->parsed(); }

Result<json> ToolCommand::Options::ask(std::uint64_t job, const std::string& order, const std::string& said,
                                       bool confirmed) const {
  ApiRequest request;
  request.op = ApiOp::kTool;
  request.job = job;
  request.command = order;
  request.words = said;
  request.confirmed = confirmed;
  const Result<std::string> line = ask_json(socket, request);
  if (!line) return tl::unexpected<Error>(line.error());
  return json::parse(*line);
}

int ToolCommand::Options::tell(const json& answer) const {
  std::cout << (as_json ? answer.dump(-1, ' ', true, json::error_handler_t::replace)
                        : answer.value("text", ""))
            << "\n";
  return kExitDone;
}

int ToolCommand::Options::go(std::uint64_t job) const {
  const Result<json> gone = ask(job, "go", "", true);
  if (!gone) return complain(gone.error());
  const auto taken = until_taken(socket, gone->dump(), "the controller has taken the way back");
  return taken ? tell(json::parse(*taken)) : complain(taken.error());
}

int ToolCommand::Options::guide(std::uint64_t job, const json& shown) const {
  ToolGuide guide;
  guide.title = shown.value("text", "");
  guide.orders = shown.value("orders", "");
  guide.wants_length = shown.contains("program_length") && !shown.contains("length");
  guide.act = [this](const std::string& name, const std::vector<std::string>& said) {
    return act_through(socket, name, said);
  };
  const auto text_of = [](const Result<json>& answer, const char* key) -> Result<std::string> {
    if (!answer) return tl::unexpected<Error>(answer.error());
    return answer->value(key, "");
  };
  guide.take_length = [&](double length) {
    return text_of(ask(job, "length", json(length).dump(), false), "text");
  };
  guide.way_back = [&] { return text_of(ask(job, "go", "", false), "confirm"); };
  if (const Result<void> guided = guide_tool_change(guide, std::cin, std::cerr); !guided)
    return complain({guided.error().code, guided.error().message + "; the job waits as before"});
  return go(job);
}

int ToolCommand::run() const {
  const Options& o = *options_;
  std::vector<std::string> words = o.words;
  std::uint64_t job = 0;
  if (!words.empty() && words[0].find_first_not_of("0123456789") == std::string::npos &&
      words[0].size() < 16) {
    job = std::stoull(words[0]);
    words.erase(words.begin());
  }
  const std::string order = words.empty() ? "" : words[0];
  const bool known = (order == "length" && words.size() == 2) ||
                     ((order == "show" || order == "go" || order.empty()) && words.size() <= 1);
  if (!known)
    return complain({Code::kUsage,
                     "tool: it is `tool [JOB] [show | length MM | go]`; without words, on a terminal, it "
                     "takes the machine's own commands, too"});
  if (order == "length" || order == "show" || (order.empty() && o.as_json)) {
    const Result<json> answer =
        o.ask(job, order == "show" ? "" : order, words.size() > 1 ? words[1] : "", false);
    return answer ? o.tell(*answer) : complain(answer.error());
  }
  if (order.empty()) {
    const Result<json> shown = o.ask(job, "", "", false);
    return shown ? o.guide(shown->value("job", std::uint64_t{0}), *shown) : complain(shown.error());
  }
  const Result<json> way = o.ask(job, "go", "", false);
  if (!way) return complain(way.error());
  std::ostream& out = o.as_json ? std::cerr : std::cout;
  out << way->value("confirm", "");
  std::string line = "yes";
  if (!o.yes) {
    out << kBackQuestion << std::flush;
    std::getline(std::cin, line);
  }
  if (line != "yes") return complain({Code::kCancelled, "nothing was sent"});
  return o.go(job);
}

}  // namespace tiltfeed::daemon
