#pragma once
// The ring protocol over Modbus: numbered blocks, identical resends, progress only by what was read back.
// Pure: no I/O and no clock, see daemon/protocol/session.h for the calls and daemon/protocol/README.md for
// the state diagram.

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "config/link_profile.h"
#include "daemon/program/numeric_block.h"
#include "daemon/protocol/session.h"
#include "daemon/wire/link.h"
#include "daemon/wire/modbus_map.h"

namespace tiltfeed::daemon {

struct ModbusOptions {
  std::uint64_t total = 0;       ///< blocks of the program
  std::uint16_t session_id = 1;  ///< not 0, another one for each run
  config::RingMap map = {};
  std::uint64_t before = 0;                  ///< blocks that another session sent, and count as executed
  config::PositionTolerance tolerance = {};  ///< of the axes at the program's end
  /// Go on with a run that another process began: session_id is that run's name.
  bool attach = false;
  std::uint16_t boot = 0;                    ///< of that run
  std::uint64_t accepted = 0, reserved = 0;  ///< blocks surely accepted, blocks that may have been sent
  std::uint64_t executed = 0;                ///< blocks surely executed
};

/// Properties: a request is repeated identically until its reply was read; blocks count as taken over only by
/// a last_accepted that was read, in one piece, for the same boot_id and session; a changed boot_id is a
/// fault and nothing is sent again; done only when last_completed reaches the last block, and the axes, where
/// they are reported, are at its end; an operator's command goes out before any block that is not out yet.
class ModbusSession {
 public:
  ModbusSession(const ModbusOptions& options, Time now);

  bool wants_work() const;
  /// Requires: wants_work().
  void push(NumericBlock block);
  /// One of those: only where it leads counts.
  void pass(const NumericBlock& block);
  void end_of_program() { ended_ = true; }
  bool wants_rewind() const { return false; }
  /// Blocks to pass() before the first push; nothing while that is not known yet.
  std::optional<std::uint64_t> first_block() const { return skip_; }

  void command(const OperatorCommand& command, Time now);
  /// The request to send now, or nothing before deadline().
  std::string_view output(Time now);
  void sent(std::size_t count);
  void receive(std::string_view reply, Time now);
  Time deadline() const { return next_request_; }
  /// The wire has gone: fault, with what may have run.
  void link_lost(const Error& error);

  Phase phase() const { return phase_; }
  SendState state() const;
  const Error& error() const { return error_; }

 private:
  /// Which step of the opening, the streaming or the closing is next.
  enum class Step { kIdentify, kLookAround, kOpen, kStream, kPlace, kClose };
  struct Mail {
    MailboxCode code = MailboxCode::kHold;
    std::uint32_t argument = 0;
  };
  struct Pending {
    NumericBlock block;
    std::array<std::uint16_t, kBlockWords> words{};
  };

  /// Full ring: short against the time that a ring of a few dozen blocks lasts, long against one exchange.
  static constexpr Time kFullRingPoll = std::chrono::milliseconds(5);

  void move(Event event);
  void make_request(Time now);
  std::vector<std::uint16_t> next_words(Time now, std::uint16_t& address);
  std::vector<std::uint16_t> window_words();
  bool idles() const;
  bool room_for_frame() const;
  bool heartbeat_due(Time now) const;

  void on_reply(const ModbusReply& reply, Time now);
  void on_missing(Time now);
  void on_exception(std::uint8_t exception, Time now);
  void on_identity(std::span<const std::uint16_t> words, Time now);
  void on_status(const RingStatus& status, Time now);
  void look_around(const RingStatus& status, Time now);
  void continue_run(const RingStatus& status, Time now);
  void post(MailboxCode code, std::uint32_t argument, Time now);
  void follow_mail(const RingStatus& status, Time now);
  void follow_hold(const RingStatus& status, Time now);
  void finish_stop();
  void on_place(std::span<const std::uint16_t> words, Time now);
  void note_hold(bool asked, Time now);
  void on_command_status(const RingStatus& status, Time now);
  void on_stream_status(const RingStatus& status, Time now);
  bool advance(const RingStatus& status, Time now);
  void judge_frame(const RingStatus& status);
  void read_again(const char* why, Time now);

  std::uint64_t accepted() const { return completed_ + accepted_pending_; }
  bool place_is_out() const;
  std::uint64_t proved() const;
  LineRange uncertain() const;
  std::string block_name(std::uint16_t seq) const;
  void fault(Code code, const std::string& what, Event event = Event::kFailed);
  void lose(Loss loss, const std::string& what);

  ModbusOptions options_;
  Phase phase_ = Phase::kConnect;
  Step step_ = Step::kIdentify;
  Error error_;
  Loss loss_ = Loss::kNone;
  RingIdentity identity_;
  RingStatus status_;
  std::optional<std::uint16_t> last_status_seq_;

  std::deque<Pending> pending_;       // from the oldest that is not completed to the newest pushed
  std::size_t accepted_pending_ = 0;  // of these, taken over by the controller
  std::size_t frame_count_ = 0;       // blocks in the frame that is out
  std::uint64_t pushed_ = 0, completed_ = 0, touched_ = 0;
  bool ran_out_ = false;               // between the last two reports all that it had was executed
  std::uint64_t known_ = 0;            // accepted before this process came
  std::optional<std::uint64_t> skip_;  // completed before this process came
  bool ended_ = false;

  std::optional<Order> ends_with_;         // stop or abort that came before the controller was known again
  std::deque<Mail> mail_;                  // the first one is out, or due
  std::optional<std::uint16_t> waits_at_;  // the newest completed block, if it is M0, M1 or M6
  int mail_tries_ = 0;                     // replies that did not acknowledge the oldest command
  Time mail_since_{};                      // it is the oldest
  bool hold_seen_ = false, aborting_ = false;
  std::string refused_, held_;
  bool beats_ = false;  // the controller's watchdog is armed
  Time late_{};         // the longest time without a heartbeat since the machine ran

  std::array<std::optional<double>, 5>
      end_;                   // where the blocks lead: X Y Z tilt rotary, as far as that is known
  std::uint64_t passed_ = 0;  // blocks read from the program
  std::uint64_t last_move_ = 0, last_move_line_ = 0;  // of these, the newest that leads to a known place
  std::uint64_t completed_line_ = 0;                  // of the newest completed block
  int place_polls_ = 0, place_failures_ = 0;
  bool elsewhere_ = false;  // after so many readings the axes were still not at the end

  std::string request_;  // out, not answered yet
  bool request_reads_status_ = false, read_only_next_ = false, use_fc23_ = true;
  bool request_is_window_ = false, judge_window_ = false;
  bool request_is_beat_ = false;  // a heartbeat that reads nothing back
  bool beat_last_ = false;        // it was the newest write
  std::uint16_t command_seq_ = 0, heartbeat_ = 0;
  std::uint64_t resends_ = 0;
  int refusals_ = 0, rereads_ = 0;
  Time next_request_{}, last_reply_{}, last_heartbeat_{}, last_progress_{}, step_began_{};
};

}  // namespace tiltfeed::daemon
