#include "daemon/machine/machine_place.h"

#include <cmath>

#include "daemon/machine/advice.h"
#include "daemon/machine/grbl_talk.h"
#include "daemon/machine/reprap_talk.h"
#include "daemon/machine/ring_talk.h"
#include "daemon/protocol/grbl_words.h"
#include "daemon/wire/modbus_map.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;

constexpr Time kRegisterRest = milliseconds(50);
constexpr int kMostReads = 20;

/// Nothing where an axis that the machine has is not among them.
std::optional<Joints> joints_of(const AxisValues& at, const MachineModel& machine) {
  const auto axis = [&](char letter) {
    const std::size_t i = kAxisLetters.find(letter);
    return i == kAxisLetters.npos ? std::nan("") : at[i];
  };
  const auto turned = [&](const RotaryAxis& one) { return one.present ? axis(one.letter) : 0.0; };
  const Joints place{axis('X'), axis('Y'), axis('Z'), turned(machine.tilt), turned(machine.rotary)};
  const bool whole = std::isfinite(place.x + place.y + place.z + place.a + place.c);
  return whole ? std::optional(place) : std::nullopt;
}

/// Programs state G54. Not where the controller has said that another offset is in force, in which it
/// reports.
Result<bool> counts_from_g54(GrblTalk& talk) {
  const Result<GrblAnswer> modes = talk.ask("$G");
  if (!modes) return tl::unexpected<Error>(modes.error());
  for (const std::string& line : modes->said) {
    if (!line.starts_with("[GC:")) continue;
    for (const char* other : {"G55", "G56", "G57", "G58", "G59"})
      if (line.find(other) != line.npos) return false;
  }
  return true;
}

Result<std::optional<Joints>> grbl_place(const MachineModel& machine, Link& wire, Clock& clock) {
  GrblTalk talk(wire, clock);
  const Result<bool> counted = counts_from_g54(talk);
  if (!counted) return tl::unexpected<Error>(counted.error());
  if (!*counted) return std::nullopt;
  const Result<GrblStatus> said = talk.report_with_offset();
  if (!said) return tl::unexpected<Error>(said.error());
  const bool known = said->in_work || talk.offset().size() == said->axes.size();
  if (!known) return std::nullopt;
  const AxisValues at = report_axes(said->axes, {}, machine),
                   offset = said->in_work ? AxisValues{} : report_axes(talk.offset(), {}, machine);
  AxisValues program = no_axes();
  for (std::size_t i = 0; i < kMostAxes; ++i) program[i] = at[i] - offset[i];
  return joints_of(program, machine);
}

/// Its own word after M400. A board that has restarted as its port was opened does not know where it is.
Result<std::optional<Joints>> reprap_place(const MachineModel& machine, Link& wire, Clock& clock) {
  RepRapTalk talk(wire, clock);
  const Result<AxisValues> at = talk.place();
  if (!at) return tl::unexpected<Error>(at.error());
  if (talk.restarted()) return std::nullopt;
  return joints_of(*at, machine);
}

Result<RingIdentity> ask_identity(const config::RingMap& map, Link& wire) {
  const auto words = read_registers(wire, map.identity, kIdentityWords);
  if (!words) return tl::unexpected<Error>(words.error());
  Result<RingIdentity> identity = parse_identity(*words);
  if (!identity) return identity;
  if (map.linear_exponent >= 0) identity->linear_exponent = map.linear_exponent;
  if (map.rotary_exponent >= 0) identity->rotary_exponent = map.rotary_exponent;
  return identity;
}

Result<std::optional<Joints>> ring_place(const config::RingMap& map, Link& wire) {
  const Result<RingIdentity> identity = ask_identity(map, wire);
  if (!identity) return tl::unexpected<Error>(identity.error());
  if (!identity->positions) return std::nullopt;
  const auto words = read_registers(wire, map.positions, kPositionsWords);
  if (!words) return tl::unexpected<Error>(words.error());
  const auto at = parse_positions(*words, *identity, map.low_word_first);
  return Joints{at[0], at[1], at[2], at[3], at[4]};
}

}  // namespace

Result<std::vector<std::uint16_t>> read_registers(Link& wire, std::uint16_t first, std::uint16_t count) {
  const ModbusRequest request{0, first, count, {}};
  for (int tries = 0; tries < kMostReads; ++tries) {
    std::string in;
    const Result<std::size_t> taken = wire.exchange(pack_request(request), Time::zero(), in);
    if (!taken) return tl::unexpected<Error>(taken.error());
    const ModbusReply reply = unpack_reply(in);
    if (reply.outcome == kReplyOk && reply.words.size() == request.read_count) return reply.words;
    in.clear();
    static_cast<void>(wire.exchange({}, kRegisterRest, in));
  }
  return fail(Code::kLink, "no usable reply from the controller; check the cable and the unit number");
}

Result<void> takes_run(const LinkSpec& link, Link& wire, Clock& clock) {
  const auto refused = [&](const std::string& state) {
    return fail(Code::kUsage,
                "the machine takes no program now (" + state + "); " + way_out_advice(link.kind));
  };
  if (link.kind == LinkKind::kGrbl) {
    GrblTalk talk(wire, clock);
    const Result<GrblStatus> said = talk.report();
    if (!said) return tl::unexpected<Error>(said.error());
    if (said->state != "Idle") return refused(grbl_state_text(said->state, 0));
  }
  if (is_ring(link.kind)) {
    RingTalk talk(link.profile.ring, wire);
    if (const Result<void> seen = talk.look(); !seen) return seen;
    if (talk.status().state == RingState::kAlarm) return refused("alarm");
  }
  return {};
}

Result<std::optional<Joints>> read_place(const LinkSpec& link, const MachineModel& machine, Link& wire,
                                         Clock& clock) {
  if (link.kind == LinkKind::kGrbl) return grbl_place(machine, wire, clock);
  if (link.kind == LinkKind::kRepRap) return reprap_place(machine, wire, clock);
  if (is_ring(link.kind)) return ring_place(link.profile.ring, wire);
  return std::nullopt;
}

}  // namespace tiltfeed::daemon
