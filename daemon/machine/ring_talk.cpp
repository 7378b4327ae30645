#include "daemon/machine/ring_talk.h"

namespace tiltfeed::daemon {

namespace {

constexpr Time kRest = std::chrono::milliseconds(50);
constexpr int kMostTries = 100;

}  // namespace

void RingTalk::rest() {
  std::string in;
  static_cast<void>(wire_.exchange({}, kRest, in));
}

Result<std::optional<std::vector<std::uint16_t>>> RingTalk::exchange(const ModbusRequest& request) {
  std::string in;
  const Result<std::size_t> taken = wire_.exchange(pack_request(request), Time::zero(), in);
  if (!taken) return tl::unexpected<Error>(taken.error());
  const ModbusReply reply = unpack_reply(in);
  if (reply.outcome == kReplyOk && reply.words.size() == request.read_count) return reply.words;
  rest();
  return std::nullopt;
}

Result<void> RingTalk::look() {
  for (int tries = 0; tries < kMostTries; ++tries) {
    const auto words = exchange({0, map_.status, kStatusWords, {}});
    if (!words) return tl::unexpected<Error>(words.error());
    if (!*words) continue;
    status_ = parse_ring_status(**words, map_.low_word_first);
    if (!status_.torn) return {};
  }
  return fail(Code::kLink, "no usable status from the controller; check the cable and the unit number");
}

bool RingTalk::tell(MailboxCode code, std::uint32_t argument) {
  const auto seq = static_cast<std::uint16_t>(status_.command_ack + 1);
  const auto words = encode_mailbox(status_.session, seq, code, argument, map_.low_word_first);
  for (int tries = 0; tries < kMostTries; ++tries) {
    if (!exchange({map_.mailbox, 0, 0, words}) || !look()) return false;
    if (status_.command_ack == seq) return status_.command_result == 0;
    rest();
  }
  return false;
}

bool RingTalk::stands() {
  for (int tries = 0; tries < kMostTries; ++tries) {
    if (!look()) return false;
    if (status_.state != RingState::kRunning) return true;
    rest();
  }
  return false;
}

}  // namespace tiltfeed::daemon
