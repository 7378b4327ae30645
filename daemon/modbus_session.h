#pragma once
// The ring protocol over Modbus: numbered blocks, identical resends, progress only by what was read back.
// Pure: no I/O and no clock, see daemon/session.h for the calls and daemon/README.md for the state diagram.

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/link.h"
#include "daemon/modbus_map.h"
#include "daemon/session.h"
#include "daemon/words.h"

namespace tiltfeed {

struct ModbusOptions {
  std::uint64_t total = 0;       ///< blocks of the program
  std::uint16_t session_id = 1;  ///< not 0, another one for each run
};

/// Properties: a request is repeated identically until its reply was read; blocks count as taken over only by
/// a last_accepted that was read, in one piece, for the same boot_id and session; a changed boot_id is a
/// fault and nothing is sent again; done only when last_completed reaches the last block.
class ModbusSession {
 public:
  ModbusSession(const ModbusOptions& options, Time now);

  bool wants_work() const;
  /// Requires: wants_work().
  void push(NumericBlock block);
  void end_of_program() { ended_ = true; }

  /// The request to send now, or nothing before deadline().
  std::string_view output(Time now);
  void sent(std::size_t count);
  void receive(std::string_view reply, Time now);
  Time deadline() const { return next_request_; }
  /// Hold by the mailbox, then fault.
  void stop();
  /// The wire has gone: fault, with what may have run.
  void link_lost(const Error& error);

  Phase phase() const { return phase_; }
  SendState state() const;
  const Error& error() const { return error_; }

 private:
  /// Which step of the opening, the streaming or the closing is next.
  enum class Step { kIdentify, kLookAround, kOpen, kStream, kClose, kHold };
  struct Pending {
    NumericBlock block;
    std::array<std::uint16_t, kBlockWords> words{};
  };

  void make_request(Time now);
  std::vector<std::uint16_t> next_words(Time now, std::uint16_t& address);
  std::vector<std::uint16_t> window_words();
  bool room_for_frame() const;
  bool heartbeat_due(Time now) const;

  void on_reply(const ModbusReply& reply, Time now);
  void on_missing(Time now);
  void on_exception(std::uint8_t exception, Time now);
  void on_identity(std::span<const std::uint16_t> words, Time now);
  void on_status(const RingStatus& status, Time now);
  void look_around(const RingStatus& status);
  void on_command_status(const RingStatus& status, Time now);
  void on_stream_status(const RingStatus& status, Time now);
  bool advance(const RingStatus& status, Time now);
  void judge_frame(const RingStatus& status);
  void read_again(const char* why, Time now);

  std::uint64_t accepted() const { return completed_ + accepted_pending_; }
  std::string uncertain_lines() const;
  std::string block_name(std::uint16_t seq) const;
  void fault(Code code, const std::string& what);

  ModbusOptions options_;
  Phase phase_ = Phase::kOpening;
  Step step_ = Step::kIdentify;
  Error error_;
  RingIdentity identity_;
  RingStatus status_;
  std::optional<std::uint16_t> last_status_seq_;

  std::deque<Pending> pending_;       // from the oldest that is not completed to the newest pushed
  std::size_t accepted_pending_ = 0;  // of these, taken over by the controller
  std::size_t frame_count_ = 0;       // blocks in the frame that is out
  std::uint64_t pushed_ = 0, completed_ = 0, touched_ = 0;
  bool ended_ = false;

  std::string request_;  // out, not answered yet
  bool request_reads_status_ = false, read_only_next_ = false, use_fc23_ = true;
  bool request_is_window_ = false, judge_window_ = false;
  std::uint16_t command_seq_ = 0, heartbeat_ = 0;
  std::uint64_t resends_ = 0;
  int refusals_ = 0, rereads_ = 0;
  Time next_request_{}, last_reply_{}, last_heartbeat_{}, last_progress_{}, step_began_{};
};

}  // namespace tiltfeed
