#pragma once
// Sends a program to a controller: the one place that owns the wire, the clock and the loop.

#include <array>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/program/line_reader.h"
#include "daemon/program/tool_change.h"
#include "daemon/protocol/session.h"
#include "daemon/stream/stream_hooks.h"
#include "daemon/wire/link.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// What another process began and the controller still knows (Modbus ring only).
struct Attachment {
  std::uint16_t session = 0, boot = 0;  ///< SendState::session and boot of that run
  std::uint64_t accepted = 0;           ///< blocks known to be accepted: a lower bound
  std::uint64_t reserved = 0;           ///< blocks that may have reached the wire: an upper bound
  std::uint64_t executed = 0;           ///< blocks that have surely run: a lower bound
};

struct SendOptions {
  std::uint16_t session_id = 0;  ///< Modbus, names the run; 0: a random one
  bool check = false;            ///< let the controller read the whole program first, without moving ($C)
  /// Go on with the block after the last that the controller accepted. Fails, with nothing sent, when the
  /// controller was restarted or has another session. The machine may be in hold: then a resume command is
  /// due.
  std::optional<Attachment> attach = {};
  /// What of the program is sent; without one: from its start to its first tool change, or its end.
  std::optional<ProgramSpan> span = {};
  /// SHA-256 that the program must have, so that the run is of what was checked.
  std::optional<std::array<std::uint8_t, 32>> program = {};
};

struct SendReport {
  LinkKind link = LinkKind::kGrbl;
  std::array<std::uint8_t, 32> program{};  ///< SHA-256 of the file
  std::uint64_t blocks = 0;                ///< of the whole program
  std::string header;                      ///< the program's (TILTFEED ...) comment, may be empty
  std::uint64_t lines = 0;         ///< blocks sent, those before the span included (Modbus: motion, dwell
                                   ///< and M blocks)
  std::uint64_t bytes = 0;         ///< taken by the wire, real-time bytes and resends included
  std::uint64_t acknowledged = 0;  ///< blocks that the controller has taken over
  std::optional<std::uint64_t>
      executed;  ///< blocks proved to be executed; nothing where the link proves none
  double seconds = 0.0;
  std::optional<ToolChange> change = {};  ///< the run stands before it; nothing: the program is at its end
  std::uint64_t resends = 0;              ///< identical requests or lines sent again
};

/// What ended a way off the part or back to it: without the range of its own short program, whose blocks no
/// operator knows. `end`: the way's newest state.
Error without_range(Error error, const SendState& end);

/// Checks the whole program, streams it, and returns at its end.
/// Properties: 1 Where anything is wrong with the program the wire is not opened. 2 Each block is given to
/// the wire once and in order, and again only as it was. 3 Without an error every block is executed, where
/// the link can prove it: SendReport::executed is set. 4 After the return nothing is sent, and nothing
/// resumes by itself. 5 An error names the lines that may have run, and none after them has.
/// Errors: kIo, kInput (program, with file:line and text), kLimit (line too long, number out of range), kLink
/// (wire or controller, with the lines that may have run), kCancelled (stopped on request, likewise).
Result<SendReport> send_program(const std::string& program_path, const LinkSpec& link,
                                const SendOptions& options, const StreamHooks& hooks);

/// Tool changes at which a run over this link ends, for the operator to make them: none where the control
/// makes them, or no machine profile is known. Errors: as read_tool_changes.
Result<std::vector<ToolChange>> kept_changes(const std::string& program_path, const LinkSpec& link);

/// Blocks of the program, as this kind of link counts them. Errors: as `send_program` before it sends.
Result<std::uint64_t> count_blocks(const std::string& program_path, LinkKind kind);
/// The same, and the SHA-256 of the file that they were counted in.
struct ProgramSum {
  std::uint64_t blocks = 0;
  std::array<std::uint8_t, 32> hash{};
  std::uint64_t waits = 0;  ///< lines with M0 M1 M6
};
Result<ProgramSum> sum_program(const std::string& program_path, LinkKind kind, const NumericAxes& axes = {});

/// The same over a wire and a clock that are given.
Result<SendReport> send_over(const std::string& program_path, const LinkSpec& spec, Link& link, Clock& clock,
                             const SendOptions& options, const StreamHooks& hooks);

}  // namespace tiltfeed::daemon
