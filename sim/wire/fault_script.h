#pragma once
// What goes wrong on a wire, on request: a text with one rule a line, seeded, so that a run can be repeated.
// The words are listed in sim/wire/README.md. A rule acts by chance (p=), or once at a time of the link
// (at=).

#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::sim {

enum class FaultKind : std::uint8_t {
  // Bytes, either way.
  kDrop,
  kDuplicate,
  kCorrupt,
  kInsert,
  kDelay,  ///< this byte and what follows, by `seconds`
  // Reply lines, to the host.
  kLoseOk,
  kExtraOk,
  kWrongLine,    ///< RepRap: a resend asks for another line
  kResendStorm,  ///< RepRap: the same resend again and again, `value` times
  // Whole links.
  kSilence,     ///< nothing passes either way for `seconds`
  kDisconnect,  ///< the device goes away for `seconds` and comes back, perhaps under another name
  kXoffStuck,   ///< an XOFF to the host, and its XON only after `seconds`
  kSlowRead,    ///< the controller reads one byte at a time: the host's writes are taken in parts
  // The controller.
  kReset,
  kAlarm,
  // Modbus frames.
  kException,    ///< answers exception `value` and does nothing
  kLoseRequest,  ///< never arrives
  kLoseReply,    ///< done, but the answer never arrives
  kLateReply,    ///< done, but the answer comes `seconds` later
  kWrongUnit,    ///< the answer names another unit
  kHalfFrame,    ///< the answer breaks off
};

enum class Side : std::uint8_t { kBoth, kToMachine, kToHost };

struct FaultRule {
  FaultKind kind = FaultKind::kDrop;
  Side side = Side::kBoth;
  double probability = 0.0;  ///< per byte, reply line or frame
  double at = -1.0;          ///< s of link time, once; below 0: by chance
  double seconds = 0.5;
  int value = 6;
};

struct FaultScript {
  std::uint64_t seed = 1;
  std::vector<FaultRule> rules;
};

/// Errors: kInput as name:line with the word that is wrong and those that exist.
Result<FaultScript> parse_fault_script(const std::string& text, const std::string& name);
Result<FaultScript> load_fault_script(const std::string& path);
const char* fault_name(FaultKind kind);

}  // namespace tiltfeed::sim
