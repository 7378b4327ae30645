#pragma once
// What a RepRap firmware (Marlin) says, one line at a time. Strict where a number is taken.

#include <cstdint>
#include <optional>
#include <string_view>

#include "daemon/wire/axis_values.h"

namespace tiltfeed::daemon {

enum class RepRapReplyKind {
  kOk,        ///< "ok", perhaps with N, P and B figures
  kResend,    ///< "Resend: n", "rs n"
  kError,     ///< "Error:..." that concerns one line and is followed by a resend
  kHalted,    ///< "Error:..." after which the firmware stands still, or "!!"
  kBusy,      ///< "echo:busy: ...", "busy:"
  kStart,     ///< the firmware has just started
  kIdentity,  ///< "FIRMWARE_NAME:...", "Cap:NAME:0|1"
  kOther,     ///< information, or damaged
};

struct RepRapReply {
  RepRapReplyKind kind = RepRapReplyKind::kOther;
  std::optional<std::uint64_t> line = {};  ///< of a resend, of "ok N", of "Last Line:"
  std::optional<int> free_commands = {};   ///< B of "ok N P B"
  bool paused = false;                     ///< busy because it waits for the user
};

RepRapReply parse_reprap_reply(std::string_view line);

/// "X:1.00 Y:2.00 Z:3.00 A:4.00 E:0.00 Count X:80 ...": up to Count, which are steps. Two decimals, no
/// checksum. Nothing: another line, or damaged.
std::optional<AxisValues> parse_reprap_place(std::string_view line);

}  // namespace tiltfeed::daemon
