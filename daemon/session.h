#pragma once
// What the sessions have in common. A session is the protocol as a pure state machine: bytes that came and
// the time go in, bytes to send, progress and the next deadline come out. No I/O, no clock, no thread.
//
// Both sessions offer the same calls, and stream.cpp drives them in this order:
//   wants_work(), push(), end_of_program()   the program, as far as the session has room for it
//   output(now), sent(count)                 bytes for the wire; `count` of them were taken
//   receive(bytes, now)                      bytes that came, perhaps none: time passes
//   deadline()                               call again at this time at the latest
//   stop(), link_lost()                      give up
//   phase(), state(), error()

#include <cstdint>
#include <string>

#include "kinematics/result.h"

namespace tiltfeed {

enum class Phase {
  kOpening,    ///< finding out who is there
  kStreaming,  ///< sending blocks
  kDraining,   ///< everything is sent, the proof that it is executed is still out
  kDone,       ///< every block is proved to be executed
  kFault,      ///< stopped; error() says why and what may have run
};

/// Progress, as shown to the user.
struct SendState {
  Phase phase = Phase::kOpening;
  std::uint64_t total = 0;         ///< blocks of the program
  std::uint64_t sent = 0;          ///< blocks given to the wire
  std::uint64_t acknowledged = 0;  ///< blocks that the controller has taken over
  std::uint64_t executed = 0;      ///< blocks that are surely executed: a lower bound
  std::uint64_t resends = 0;
  std::string machine;  ///< the machine's own word for its state: Idle, Run, Hold, ...
};

/// "opening", "streaming", ...
const char* phase_name(Phase phase);
/// "line 12 'G1X3'" for messages.
std::string quote_line(std::uint64_t number, const std::string& text);

}  // namespace tiltfeed
