#pragma once
// What takes several machine commands: the controller's settings and a file, a guided tool change. The same
// over a link of its own and through the service.

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "daemon/machine/machine_orders.h"

namespace tiltfeed::daemon {

using MachineAct =
    std::function<Result<MachineAnswer>(const std::string& name, const std::vector<std::string>& words)>;

/// `settings save FILE`, `restore FILE`, `compare FILE`. Restoring sets what differs, one by one, each read
/// back; what is refused is tried again after the rest. Comparing: an error where anything differs.
Result<MachineAnswer> settings_file(const MachineAct& act, const std::string& what, const std::string& path);
/// Is it one of those?
bool is_settings_file(const std::string& name, const std::vector<std::string>& words);

/// `tool change`: park, wait for the operator, measure or take the length. Asks on `out`, hears on `in`.
Result<MachineAnswer> change_tool(const MachineAct& act, std::istream& in, std::ostream& out);

}  // namespace tiltfeed::daemon
