#include "daemon/machine_place.h"

#include <algorithm>
#include <cmath>

#include "daemon/grbl_reply.h"
#include "daemon/modbus_map.h"

namespace tiltfeed {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Time kAskAgain = milliseconds(50), kPlaceTime = seconds(5);
constexpr int kMostTries = 20;
constexpr std::size_t kMostReply = 1024, kFiveAxes = 5;

/// Asks for reports until one has a place in program coordinates: the offset comes with every tenth.
Result<std::optional<Joints>> grbl_place(const MachineModel& machine, Link& wire, Clock& clock) {
  std::string letters = "XYZ";
  for (const char letter : kAxisLetters.substr(3))
    if (letter == machine.tilt.letter || letter == machine.rotary.letter) letters += letter;
  std::string out, line;
  std::vector<double> offset;
  Time ask = clock.now();
  for (const Time began = clock.now(); clock.now() - began < kPlaceTime;) {
    if (clock.now() >= ask) {
      out += '?';
      ask = clock.now() + kAskAgain;
    }
    std::string in;
    const Result<std::size_t> taken = wire.exchange(out, std::max(ask - clock.now(), Time::zero()), in);
    if (!taken) return tl::unexpected<Error>(taken.error());
    out.erase(0, *taken);
    for (const char c : in) {
      if (c != '\n') {
        if (c != '\r' && line.size() < kMostReply) line += c;
        continue;
      }
      const std::string report = std::move(line);
      line.clear();
      const bool status = classify_reply(report) == GrblReplyKind::kStatus;
      const std::optional<GrblStatus> said = status ? parse_status(report) : std::nullopt;
      if (!said) continue;
      if (!said->offset.empty()) offset = said->offset;
      if (said->axes.size() != kFiveAxes || letters.size() != kFiveAxes) continue;
      if (!said->in_work && offset.size() != kFiveAxes) continue;
      const auto axis = [&](char letter) {
        const std::size_t i = letters.find(letter);
        return said->axes[i] - (said->in_work ? 0.0 : offset[i]);
      };
      return Joints{axis('X'), axis('Y'), axis('Z'), axis(machine.tilt.letter), axis(machine.rotary.letter)};
    }
  }
  return std::nullopt;
}

/// Registers of a ring controller, asked for until they come.
Result<std::vector<std::uint16_t>> ask(Link& wire, const ModbusRequest& request) {
  for (int tries = 0; tries < kMostTries; ++tries) {
    std::string in;
    const Result<std::size_t> taken = wire.exchange(pack_request(request), Time::zero(), in);
    if (!taken) return tl::unexpected<Error>(taken.error());
    const ModbusReply reply = unpack_reply(in);
    if (reply.outcome == kReplyOk && reply.words.size() == request.read_count) return reply.words;
    in.clear();
    static_cast<void>(wire.exchange({}, kAskAgain, in));
  }
  return fail(Code::kLink, "no usable reply from the controller; check the cable and the unit number");
}

Result<RingIdentity> ask_identity(const RingMap& map, Link& wire) {
  const auto words = ask(wire, {0, map.identity, kIdentityWords, {}});
  if (!words) return tl::unexpected<Error>(words.error());
  Result<RingIdentity> identity = parse_identity(*words);
  if (!identity) return identity;
  if (map.linear_exponent >= 0) identity->linear_exponent = map.linear_exponent;
  if (map.rotary_exponent >= 0) identity->rotary_exponent = map.rotary_exponent;
  return identity;
}

Result<std::optional<Joints>> ring_place(const RingMap& map, Link& wire) {
  const Result<RingIdentity> identity = ask_identity(map, wire);
  if (!identity) return tl::unexpected<Error>(identity.error());
  if (!identity->positions) return std::nullopt;
  const auto words = ask(wire, {0, map.positions, kPositionsWords, {}});
  if (!words) return tl::unexpected<Error>(words.error());
  const auto at = parse_positions(*words, *identity, map.low_word_first);
  return Joints{at[0], at[1], at[2], at[3], at[4]};
}

}  // namespace

Result<std::optional<Joints>> read_place(const LinkSpec& link, const MachineModel& machine, Link& wire,
                                         Clock& clock) {
  if (link.kind == LinkKind::kGrbl) return grbl_place(machine, wire, clock);
  if (is_ring(link.kind)) return ring_place(link.profile.ring, wire);
  return std::nullopt;
}

}  // namespace tiltfeed
