#pragma once
// What an operator does with a machine before and after a program: one table of commands, for the plain
// command line and the service alike. Each says only what the controller proved.

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/machine_profile.h"
#include "daemon/machine/machine_bench.h"
#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

using MachineDeed = Result<MachineAnswer> (*)(const MachineBench&, const std::vector<std::string>& words);

struct MachineOrder {
  const char* name;
  const char* words;   ///< what may follow it, for --help
  const char* what;    ///< for --help
  bool while_running;  ///< the service has an answer of its own while a program is on the machine
  // By the kind of controller; none: it has no words for it.
  MachineDeed grbl, reprap = nullptr, ring = nullptr, drive = nullptr;
};

std::span<const MachineOrder> machine_orders();
/// Nothing: this kind of controller has no words for it.
MachineDeed deed_of(const MachineOrder& order, LinkKind kind);
/// Nothing where there is no such command.
const MachineOrder* find_machine_order(std::string_view name);

/// Errors: kUsage: an unknown command, words that it does not take, a link that cannot do it; kLimit: a place
/// beyond the profile's travel; kLink with the controller's number in words; kCancelled.
Result<MachineAnswer> perform_order(const MachineBench& bench, std::string_view name,
                                    const std::vector<std::string>& words);

}  // namespace tiltfeed::daemon
