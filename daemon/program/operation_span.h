#pragma once
// Where a program's comments say that a job's operations begin: "TILTFEED operation 2 of 3 NAME".

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/program/link_kind.h"
#include "kinematics/basics/result.h"
#include "kinematics/machine/machine_model.h"

namespace tiltfeed::daemon {

/// One operation of a posted program.
struct OperationSpan {
  std::string name;
  std::uint64_t number = 1, count = 1;  ///< from 1
  std::uint64_t first = 1;              ///< block that it begins with, counted from 1 as the link counts
};

/// In their order; none where the program names none. Over links that count lines the program may be in the
/// words of any control. Errors: kIo; kInput: as LineReader; of links that count numeric blocks as
/// BlockCursor.
Result<std::vector<OperationSpan>> read_operations(const std::string& path, LinkKind kind,
                                                   const MachineModel& machine);
/// The one that has the block; null: none, or it stands before the first.
const OperationSpan* operation_at(const std::vector<OperationSpan>& operations, std::uint64_t block);

}  // namespace tiltfeed::daemon
