#include "daemon/command/machine_command.h"

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "config/yaml_tree.h"
#include "daemon/command/command.h"
#include "daemon/command/held_keys.h"
#include "daemon/command/interrupt.h"
#include "daemon/machine/machine_guides.h"
#include "daemon/measure/check_result.h"
#include "daemon/post/machine_check.h"
#include "daemon/service/api.h"
#include "daemon/service/api_socket.h"
#include "daemon/service/state_lock.h"
#include "daemon/wire/open_link.h"
#include "daemon/wire/steady_clock.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::json;

constexpr std::chrono::milliseconds kAskAgain{50};

std::atomic<bool> hung_up{false};
extern "C" void take_hang_up(int) { hung_up = true; }

bool wants_end() { return interrupted() || hung_up; }

Result<json> ask(const std::string& socket, const ApiRequest& request) {
  const Result<std::string> line = ask_service(socket, write_request(request), {});
  if (!line) return tl::unexpected<Error>(line.error());
  json answer = json::parse(*line, nullptr, false);
  if (!answer.is_object()) return fail(Code::kIo, socket + ": the answer is not understood");
  if (!answer.value("ok", false)) return fail(Code::kInput, answer.value("error", "refused"));
  return answer;
}

}  // namespace

Result<MachineAnswer> act_over(const LinkSpec& link, const config::MachineProfile& machine,
                               const std::string& name, const std::vector<std::string>& words) {
  // A serial port is locked by opening it; an address is not.
  MachineClaim claim;
  if (link.over_network())
    if (const Result<void> mine = claim.follow(link); !mine) return tl::unexpected<Error>(mine.error());
  Result<std::unique_ptr<Link>> wire = open_link(link);
  if (!wire) return tl::unexpected<Error>(wire.error());
  SteadyClock clock;
  MachineBench bench{machine, link, **wire, clock};
  bench.stopped = wants_end;
  std::optional<HeldKeys> keys;
  bench.held = [&keys] {
    if (!keys) keys.emplace();
    return keys->held();
  };
  return perform_order(bench, name, words);
}

Result<MachineAnswer> act_through(const std::string& socket, const std::string& name,
                                  const std::vector<std::string>& words) {
  ApiRequest request;
  request.op = ApiOp::kMachine;
  request.command = name;
  for (const std::string& word : words) request.words += (request.words.empty() ? "" : " ") + word;
  Result<json> answer = ask(socket, request);
  const bool goes_on =
      name == "jog" && !words.empty() && (words[0].ends_with('+') || words[0].ends_with('-'));
  std::optional<HeldKeys> keys;
  if (goes_on) keys.emplace();
  if (answer) request.order = answer->value("order", std::uint64_t{0});
  while (answer && !answer->contains("text")) {
    std::this_thread::sleep_for(kAskAgain);
    request.stop = wants_end();
    request.held = keys && keys->held();
    answer = ask(socket, request);
  }
  if (!answer) return tl::unexpected<Error>(answer.error());
  return MachineAnswer{answer->value("text", ""), answer->value("result", json::object()).dump()};
}

struct MachineCommands::Options {
  CLI::App *check = nullptr, *order = nullptr;
  std::string profile, found, machine, link, name, socket;
  std::vector<std::string> words;
  double tool_length = 100.0, height = 100.0, aside = 0.0, within = 0.02;
  bool as_json = false;

  int run_check() const;
  int judge(const config::MachineProfile& loaded) const;
  int run_order() const;
  Result<MachineAct> way() const;
};

MachineCommands::MachineCommands(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  CLI::App* machine = app.add_subcommand(
      "machine", "the machine in the shop: its profile, and what is done with it before and after a program");
  machine->require_subcommand(1);
  o.check = machine->add_subcommand(
      "check", "check a profile's measured places, print a test program and where the tool should be");
  o.check->add_option("PROFILE", o.profile, "machine profile (YAML)")->required();
  o.check->add_option("--tool-length", o.tool_length, "gauge line to tip, mm (100)")
      ->check(CLI::Range(0.0, 1e4));
  o.check->add_option("--height", o.height, "of the tip over the zero point, mm (100)");
  o.check
      ->add_option(
          "--aside", o.aside,
          "of the tip beside the rotary's axis, along X with the rotaries at home, mm (0); beside it "
          "the stops tell which way a table turns")
      ->check(CLI::Range(-1e4, 1e4));
  o.check->add_option(
      "--found", o.found,
      "CSV of what was found at the program's stops: stop,x_mm,y_mm,z_mm, the words at which the tip "
      "is where it was at stop 1; or stop,dx_mm,dy_mm,dz_mm, by how much it is off. Says passed, or "
      "what to change");
  o.check->add_option("--within", o.within, "allowed with --found, mm (0.02)")->check(CLI::Range(1e-4, 10.0));
  o.check->add_flag("--json", o.as_json, "print one JSON object");
  o.socket = service_socket();
  for (const MachineOrder& one : machine_orders()) {
    CLI::App* const order = machine->add_subcommand(one.name, one.what);
    if (*one.words != '\0') order->add_option("WORDS", o.words, one.words);
    order->add_option("--machine", o.machine,
                      "without a service: machine profile (YAML), its travels and its default link");
    order->add_option("--link", o.link, "without a service: as of `tiltfeed send`; else the profile's");
    order->add_option(
        "--socket", o.socket,
        "the service's socket (default: $TILTFEED_SOCKET, else " + std::string(kDefaultSocket) + ")");
    order->add_flag("--json", o.as_json, "print one JSON object");
    order->callback([&o, &one] { o.name = one.name; });
  }
}

MachineCommands::~MachineCommands() = default;

bool MachineCommands::called() const { return options_->check->parsed() || at_machine(); }
bool MachineCommands::at_machine() const { return !options_->name.empty(); }
int MachineCommands::run() const { return at_machine() ? options_->run_order() : options_->run_check(); }

/// What was found at the stops.
int MachineCommands::Options::judge(const config::MachineProfile& loaded) const {
  const Result<std::string> table = config::read_config_text(found);
  if (!table) return complain(table.error());
  const Result<CheckResult> result = judge_check(loaded, tool_length, height, aside, *table, found, within);
  if (!result) return complain(result.error());
  if (as_json) {
    nlohmann::ordered_json all = {{"profile", profile},
                                  {"passed", result->passed},
                                  {"stops", result->stops},
                                  {"worst_mm", result->worst},
                                  {"where", result->where},
                                  {"not_told", result->unseen},
                                  {"remedies", nlohmann::ordered_json::array()}};
    for (const CheckRemedy& one : result->remedies)
      all["remedies"].push_back({{"change", one.change}, {"worst_mm", one.worst}});
    show_json(all.dump(-1, ' ', true, json::error_handler_t::replace));
  } else {
    std::cout << profile << ": " << text_of(*result, within) << "\n";
  }
  return result->passed ? kExitDone : kExitFailed;
}

int MachineCommands::Options::run_check() const {
  const auto loaded = config::load_machine(profile);
  if (loaded && !found.empty()) return judge(*loaded);
  const auto program =
      loaded ? check_program(*loaded, tool_length, height, aside) : tl::unexpected(loaded.error());
  if (!program) {
    std::cerr << "tiltfeed: " << program.error().message << "\n";
    return kExitFailed;
  }
  if (as_json)
    return show_json(nlohmann::ordered_json(
                         {{"profile", profile}, {"places", loaded->vectors.size()}, {"program", *program}})
                         .dump(-1, ' ', true, json::error_handler_t::replace));
  std::cerr << profile << ": " << loaded->vectors.size() << " measured places agree\n";
  std::cout << *program;
  return kExitDone;
}

/// Over a link where one is named, else through the service. Errors: kUsage, those of the profile.
Result<MachineAct> MachineCommands::Options::way() const {
  if (machine.empty() && link.empty())
    return [this](const std::string& command, const std::vector<std::string>& said) {
      return act_through(socket, command, said);
    };
  if (machine.empty()) return fail(Code::kUsage, "--link needs --machine: the profile's travels hold for it");
  const auto loaded = config::load_machine(machine);
  if (!loaded) return tl::unexpected<Error>(loaded.error());
  const auto spec = parse_link(link.empty() ? loaded->link : link, loaded->wire, &loaded->model);
  if (!spec) return tl::unexpected<Error>(spec.error());
  return [spec = *spec, profile = *loaded](const std::string& command, const std::vector<std::string>& said) {
    return act_over(spec, profile, command, said);
  };
}

int MachineCommands::Options::run_order() const {
  std::signal(SIGHUP, take_hang_up);
  std::signal(SIGPIPE, SIG_IGN);
  const Result<MachineAct> act = way();
  if (!act) return complain(act.error());
  const bool guided = name == "tool" && words == std::vector<std::string>{"change"};
  const Result<MachineAnswer> answer = is_settings_file(name, words) ? settings_file(*act, words[0], words[1])
                                       : guided                      ? change_tool(*act, std::cin, std::cerr)
                                                                     : (*act)(name, words);
  if (!answer) return complain(answer.error());
  std::cout << (as_json ? answer->json : answer->text) << "\n";
  return kExitDone;
}

}  // namespace tiltfeed::daemon
