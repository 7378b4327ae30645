#include "daemon/machine_command.h"

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <iostream>
#include <string>
#include <vector>

#include "daemon/held_keys.h"
#include "daemon/interrupt.h"
#include "daemon/machine_check.h"
#include "daemon/machine_orders.h"

namespace tiltfeed {

namespace {

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2;

std::atomic<bool> hung_up{false};
extern "C" void take_hang_up(int) { hung_up = true; }

class SteadyClock : public Clock {
 public:
  Time now() override { return std::chrono::steady_clock::now().time_since_epoch(); }
};

int complain(const Error& error) {
  std::cerr << "tiltfeed: " << error.message << "\n";
  return error.code == Code::kUsage ? kWrongUse : kFailed;
}

/// Over a link of its own.
Result<MachineAnswer> act_over(const LinkSpec& link, const MachineProfile& machine, const std::string& name,
                               const std::vector<std::string>& words) {
  Result<std::unique_ptr<Link>> wire = open_link(link);
  if (!wire) return tl::unexpected<Error>(wire.error());
  SteadyClock clock;
  std::signal(SIGHUP, take_hang_up);
  std::signal(SIGPIPE, SIG_IGN);
  MachineBench bench{machine, link, **wire, clock};
  bench.stopped = [] { return interrupted() || hung_up; };
  std::optional<HeldKeys> keys;
  bench.held = [&keys] {
    if (!keys) keys.emplace();
    return keys->held();
  };
  return perform_order(bench, name, words);
}

}  // namespace

struct MachineCommands::Options {
  CLI::App *check = nullptr, *order = nullptr;
  std::string profile, machine, link, name;
  std::vector<std::string> words;
  double tool_length = 100.0, height = 100.0;
  bool json = false;

  int run_check() const;
  int run_order() const;
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
  for (const MachineOrder& one : machine_orders()) {
    CLI::App* const order = machine->add_subcommand(one.name, one.what);
    if (*one.words != '\0') order->add_option("WORDS", o.words, one.words);
    order->add_option("--machine", o.machine, "machine profile (YAML): its travels and its default link")
        ->required();
    order->add_option("--link", o.link, "as of `tiltfeed send`; else the profile's");
    order->add_flag("--json", o.json, "print one JSON object");
    order->callback([&o, &one] { o.name = one.name; });
  }
}

MachineCommands::~MachineCommands() = default;

bool MachineCommands::called() const { return options_->check->parsed() || at_machine(); }
bool MachineCommands::at_machine() const { return !options_->name.empty(); }
int MachineCommands::run() const { return at_machine() ? options_->run_order() : options_->run_check(); }

int MachineCommands::Options::run_check() const {
  const auto loaded = load_machine(profile);
  const auto program = loaded ? check_program(*loaded, tool_length, height) : tl::unexpected(loaded.error());
  if (!program) {
    std::cerr << "tiltfeed: " << program.error().message << "\n";
    return kFailed;
  }
  std::cerr << profile << ": " << loaded->vectors.size() << " measured places agree\n";
  std::cout << *program;
  return kDone;
}

int MachineCommands::Options::run_order() const {
  const auto loaded = load_machine(machine);
  if (!loaded) return complain(loaded.error());
  const auto spec = parse_link(link.empty() ? loaded->link : link, loaded->wire, &loaded->model);
  if (!spec) return complain(spec.error());
  const Result<MachineAnswer> answer = act_over(*spec, *loaded, name, words);
  if (!answer) return complain(answer.error());
  std::cout << (json ? answer->json : answer->text) << "\n";
  return kDone;
}

}  // namespace tiltfeed
