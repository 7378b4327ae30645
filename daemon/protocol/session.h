#pragma once
// What the sessions have in common: phases, events, what an operator may ask for, progress. A session is the
// protocol as a pure state machine: bytes that came and the time go in, bytes to send, progress and the next
// deadline come out. No I/O, no clock, no thread. daemon/protocol/README.md draws phases and transitions.
//
// All sessions offer the same calls, and stream.cpp drives them in this order:
// * wants_work(), push(), end_of_program(): the program, as far as the session has room for it;
// * wants_rewind(): the program is wanted once more from its first block (after a check);
// * command(command, now): an operator's wish;
// * output(now), sent(count): bytes for the wire; `count` of them were taken;
// * receive(bytes, now): bytes that came, perhaps none: time passes;
// * deadline(): call again at this time at the latest;
// * link_lost(): the wire has gone;
// * phase(), state(), error().
//
// Properties of every session: 1 A final phase has no way out; every other can end in kFault and kAlarm.
// 2 kDone comes after kDrain only. 3 An order that is obeyed has its transition in the phase. 4 No session
// ends a hold by itself. 5 executed <= acknowledged <= sent.

#include <cstdint>
#include <optional>
#include <string>

#include "daemon/wire/axis_values.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

enum class Phase {
  kConnect,     ///< waiting for the controller's first sign of life
  kIdentify,    ///< asking who it is and how large its buffers are
  kCheck,       ///< the controller reads the program without moving (Grbl $C)
  kRun,         ///< sending blocks
  kHold,        ///< feed hold, asked for or found: the session never ends it by itself
  kToolChange,  ///< M0, M1 or M6 is alone in the controller: it waits for the operator
  kDrain,       ///< everything is sent, the proof that it is executed is still out
  kStop,        ///< held for good; waiting until the machine stands
  kDone,        ///< every block is executed, by the proof that the link has (drip feed: sent)
  kStopped,     ///< stopped on request; error() says what may have run
  kAlarm,       ///< the controller is in alarm; error() as above
  kFault,       ///< wire or controller failed; error() as above
};

enum class Event {
  kAnswered,      ///< the controller has spoken
  kCheckBegins,   ///< it is in check mode
  kChecked,       ///< it found nothing wrong and restarts
  kReady,         ///< blocks may be sent
  kHeld,          ///< hold was sent, or the controller says that it holds
  kResumed,       ///< resume was sent and the controller goes on
  kOperatorStop,  ///< M0, M1 or M6 begins to wait
  kOperatorDone,  ///< it was answered
  kAllSent,       ///< the last block is on its way
  kProved,        ///< the controller has proved that the last block is executed
  kStopAsked,     ///< stop command
  kStood,         ///< the machine stands and has forgotten the rest
  kAlarm,
  kFailed,  ///< anything that makes the rest unsafe
};

/// Where `event` leads from `phase`; nothing where it has no place. A final phase has no way out.
std::optional<Phase> next_phase(Phase phase, Event event);
/// kDone, kStopped, kAlarm, kFault.
bool is_final(Phase phase);
/// kConnect, kIdentify, kCheck: nothing has moved yet.
bool is_opening(Phase phase);
/// "connect", "run", ...
const char* phase_name(Phase phase);
const char* event_name(Event event);

/// What a run that did not come to its end leaves behind: decisions look at this, never at a message.
enum class Loss : std::uint8_t {
  kNone,       ///< nothing that the controller would not still know
  kWire,       ///< no reply, or the wire has gone: the controller may have everything
  kRestarted,  ///< the controller has started anew: what was not completed is unknown
  kForgotten,  ///< it has dropped what it had of the run, or has another session
};
const char* loss_name(Loss loss);

enum class Order : std::uint8_t {
  kHold,             ///< feed hold: overtakes everything that is buffered
  kResume,           ///< ends a hold or a tool change
  kStop,             ///< hold, wait until the machine stands, make it forget the rest
  kAbort,            ///< reset at once: position not to be trusted
  kFeedOverride,     ///< value: percent, kMinOverride to kMaxOverride
  kRapidOverride,    ///< value: 25, 50 or 100 percent
  kSpindleOverride,  ///< value: percent, likewise
};
inline constexpr int kMinOverride = 10, kMaxOverride = 200;
/// What an operator asks for. What the controller does not have is ignored and SendState::refused says so.
struct OperatorCommand {
  Order order = Order::kHold;
  int value = 0;
};

/// How every session meets an order, by its phase; what the link can do of it is the session's own matter.
enum class Answer : std::uint8_t {
  kObey,
  kIgnore,      ///< it is so already, or too late
  kNotHeld,     ///< refused: there is nothing to resume
  kNothingYet,  ///< refused: nothing moves yet
  kEnd,         ///< nothing was sent: the run ends at once
};
Answer answer_to(Order order, Phase phase);
/// Why an order is refused; empty where it is not.
const char* refusal_text(Answer answer);

/// Bytes of a reply line: it is shorter on every known firmware; longer ones are noise.
inline constexpr std::size_t kMaxReplyLine = 1024;

/// Lines of the program file; 0, 0: none.
struct LineRange {
  std::uint64_t first = 0, last = 0;
};

/// Progress, as shown to the user and as written to a journal. A block is a line (Grbl, RepRap, drip feed) or
/// a numeric block (Modbus); all counts are of blocks from the program's begin. Once the axes stand for good
/// and the rest is forgotten, blocks that cannot have run count neither as sent nor as taken over.
struct SendState {
  Phase phase = Phase::kConnect;
  std::uint64_t total = 0;         ///< blocks of the program
  std::uint64_t sent = 0;          ///< blocks of which at least one byte was given to the wire
  std::uint64_t acknowledged = 0;  ///< blocks that the controller has taken over
  std::uint64_t executed = 0;      ///< blocks that are surely executed: a lower bound
  std::uint64_t resends = 0;
  std::string machine = {};   ///< the machine's own word for its state: Idle, Run, Hold, ...
  std::uint64_t line = 0;     ///< program line in execution, where the controller tells; 0: unknown
  LineRange uncertain = {};   ///< lines that may or may not have run, if everything ended now
  bool elsewhere = false;     ///< the axes are not where blocks counted as executed lead
  Loss loss = Loss::kNone;    ///< kFault, kAlarm: what of the run is lost
  bool provable = false;      ///< the link can continue with the next block after a loss (Modbus ring)
  std::uint16_t session = 0;  ///< Modbus: name of the run in the controller
  std::uint16_t boot = 0;     ///< Modbus: the controller's boot_id
  int feed_override = 0;      ///< percent as the controller reports it; 0: unknown
  int rapid_override = 0, spindle_override = 0;  ///< likewise
  double feed = -1.0, spindle = -1.0;            ///< as reported now, mm/min and 1/min; -1: not known
  AxisValues place = no_axes();  ///< as reported, program coordinates; not a number: not known
  /// It had run out by its last word, although blocks are left to send; nothing: the link does not tell.
  std::optional<bool> starved = {};
  std::string held = {};     ///< in a hold: who holds it, as far as that is known
  std::string refused = {};  ///< why the last operator command was not obeyed; empty: it was
};

/// "line 12 'G1X3'" for messages.
std::string quote_line(std::uint64_t number, const std::string& text);
/// "blocks 2 to 8", "block 2".
std::string numbered(const std::string& of, const LineRange& range);
/// "blocks 2 to 8 may have run (lines 3 to 9 of the file); earlier ones have, later ones have not": blocks
/// are what `resume --from` counts.
std::string describe(const SendState& state);

}  // namespace tiltfeed::daemon
