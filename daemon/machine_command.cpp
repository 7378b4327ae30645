#include "daemon/machine_command.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <string>

#include "daemon/machine_check.h"

namespace tiltfeed {

struct MachineCommands::Options {
  CLI::App* check = nullptr;
  std::string profile;
  double tool_length = 100.0, height = 100.0;
};

MachineCommands::MachineCommands(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  CLI::App* machine = app.add_subcommand("machine", "a machine profile and the machine in the shop");
  machine->require_subcommand(1);
  o.check = machine->add_subcommand(
      "check", "check a profile's measured places, print a test program and where the tool should be");
  o.check->add_option("PROFILE", o.profile, "machine profile (YAML)")->required();
  o.check->add_option("--tool-length", o.tool_length, "gauge line to tip, mm (100)")
      ->check(CLI::Range(0.0, 1e4));
  o.check->add_option("--height", o.height, "of the tip over the zero point, mm (100)");
}

MachineCommands::~MachineCommands() = default;

bool MachineCommands::called() const { return options_->check->parsed(); }

int MachineCommands::run() const {
  const auto machine = load_machine(options_->profile);
  const auto program = machine ? check_program(*machine, options_->tool_length, options_->height)
                               : tl::unexpected(machine.error());
  if (!program) {
    std::cerr << "tiltfeed: " << program.error().message << "\n";
    return 1;
  }
  std::cerr << options_->profile << ": " << machine->vectors.size() << " measured places agree\n";
  std::cout << *program;
  return 0;
}

}  // namespace tiltfeed
