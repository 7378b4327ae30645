// Modbus replies of any content: the session never counts a block that it did not send, and never ends well
// by itself.

#include "daemon/protocol/modbus_session.h"
#include "daemon/wire/modbus_map.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;
using namespace tiltfeed::config;
using namespace tiltfeed::daemon;

namespace {

/// An identity and a status that fit, so that damage gets past the opening.
ModbusReply plausible(std::size_t words, std::uint16_t status_seq, unsigned char flavour) {
  ModbusReply reply{kReplyOk, std::vector<std::uint16_t>(words)};
  if (words == kIdentityWords) reply.words = {0x5446, 1, 3, 64, 16, 7, 31, 4, 4, 9, 0, 0, 0, 0, 0, 0};
  if (words == kStatusWords) {
    reply.words[0] = reply.words[23] = status_seq;
    reply.words[1] = 9;
    reply.words[2] = 5;
    reply.words[6] = 64;
    reply.words[7] = flavour % 3;
    reply.words[11] = flavour / 8;
  }
  return reply;
}

}  // namespace

FUZZ_TARGET(modbus) {
  ModbusOptions options;
  options.total = 40;
  options.session_id = 5;
  Time now{0};
  ModbusSession session(options, now);
  std::uint64_t pushed = 0;
  std::uint16_t status_seq = 0;
  std::size_t at = 0;
  const auto byte = [&] {
    return at < bytes.size() ? static_cast<unsigned char>(bytes[at++]) : static_cast<unsigned char>(0);
  };
  while (at < bytes.size() && !is_final(session.phase())) {
    while (session.wants_work() && pushed < 40) {
      NumericBlock block;
      block.op = BlockOp::kRapid;
      block.line = ++pushed;
      session.push(block);
    }
    if (pushed == 40) session.end_of_program();
    const std::string request(session.output(now));
    now += std::chrono::milliseconds(byte());
    if (request.empty()) continue;
    session.sent(request.size());
    ModbusReply reply = plausible(unpack_request(request).read_count, ++status_seq, byte());
    for (int damage = byte() % 4; damage > 0 && !reply.words.empty(); --damage) {
      const std::size_t place = byte() % reply.words.size();
      const unsigned high = byte(), low = byte();
      reply.words[place] = static_cast<std::uint16_t>(high << 8 | low);
    }
    const unsigned char kind = byte();
    if (kind > 240) reply.outcome = kind;
    if (kind > 200 && kind <= 220) reply.words.resize(kind % 30);
    session.receive(pack_reply(reply), now);
    const SendState state = session.state();
    HOLDS(state.executed <= state.acknowledged && state.acknowledged <= state.sent && state.sent <= pushed);
  }
  HOLDS(session.phase() != Phase::kDone || session.state().executed == 40);
}
