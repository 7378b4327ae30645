// What a ring controller's mailbox and status offer an operator: `machine unlock`, `machine override feed`.

#include <nlohmann/json.hpp>

#include "daemon/machine/order_parts.h"
#include "daemon/machine/ring_talk.h"

namespace tiltfeed::daemon {

using nlohmann::ordered_json;

Result<MachineAnswer> ring_unlock(const MachineBench& bench, const OrderWords& words) {
  if (!words.empty()) return wrong_words("unlock", "takes no words");
  RingTalk talk(bench.link.profile.ring, bench.wire);
  if (const Result<void> looked = talk.look(); !looked) return tl::unexpected<Error>(looked.error());
  const RingStatus before = talk.status();
  if (before.state != RingState::kAlarm)
    return MachineAnswer{std::string("the machine is in no alarm: state ") + ring_state_name(before.state) +
                             "; nothing was sent",
                         R"({"unlocked":false})"};
  const std::string alarm = "alarm " + std::to_string(before.alarm);
  if (!talk.tell(MailboxCode::kClearAlarm) || talk.status().state == RingState::kAlarm)
    return fail(Code::kLink, alarm +
                                 " stays: end its cause at the machine; where that is not enough "
                                 "`tiltfeed reset` is");
  return MachineAnswer{alarm +
                           " is cleared; the blocks that the controller had are dropped, and its position is "
                           "not to be trusted where the axes may have slipped: home it at the control",
                       R"({"unlocked":true})"};
}

Result<MachineAnswer> ring_override(const MachineBench& bench, const OrderWords& words) {
  const std::optional<int> percent = override_percent(words);
  if (!percent || words[0] != "feed")
    return wrong_words("override", "a ring controller has a feed override only, of 10 to 200 percent");
  RingTalk talk(bench.link.profile.ring, bench.wire);
  if (const Result<void> looked = talk.look(); !looked) return tl::unexpected<Error>(looked.error());
  if (!talk.tell(MailboxCode::kOverride, static_cast<std::uint32_t>(*percent)))
    return fail(Code::kLink, "the controller refuses the override (state " +
                                 std::string(ring_state_name(talk.status().state)) + ")");
  if (talk.status().feed_override != *percent)
    return fail(Code::kLink, "the controller took the override and reports " +
                                 std::to_string(talk.status().feed_override) + " percent");
  return MachineAnswer{"feed override " + words[1] + " %",
                       ordered_json({{"override", "feed"}, {"percent", *percent}}).dump()};
}

}  // namespace tiltfeed::daemon
