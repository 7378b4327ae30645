#pragma once
// That a command which may move the machine is in work: a file that outlives the process, so that whoever
// stops what a dead service left knows of it.

#include <cstdint>
#include <optional>
#include <string>

#include "daemon/program/link_kind.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

struct MarkedOrder {
  std::optional<LinkKind> link;  ///< nothing: the file cannot be read
  std::string text;              ///< "jog X10 F500", or why the file cannot be read
};

/// `folder`: of the spool. Nothing is synced: after a power loss nothing moves. Errors: kIo.
Result<void> mark_order(const std::string& folder, LinkKind link, const std::string& text);
void clear_order_mark(const std::string& folder);
/// Nothing: no command was in work.
std::optional<MarkedOrder> marked_order(const std::string& folder);

}  // namespace tiltfeed::daemon
