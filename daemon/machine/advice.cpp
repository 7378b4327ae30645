#include "daemon/machine/advice.h"

#include <vector>

#include "daemon/machine/machine_orders.h"

namespace tiltfeed::daemon {

bool can_order(LinkKind kind, std::string_view order) {
  if (order == "reset") return kind != LinkKind::kDrip;
  const std::size_t end = order.find(' ');
  const MachineOrder* const one = find_machine_order(order.substr(0, end));
  if (one == nullptr || deed_of(*one, kind) == nullptr) return false;
  // A length is measured by probing.
  return order != "tool measure" || can_order(kind, "probe");
}

std::string possible_of(LinkKind kind, std::span<const std::string_view> orders) {
  std::vector<std::string_view> possible;
  for (const std::string_view order : orders)
    if (can_order(kind, order)) possible.push_back(order);
  std::string text;
  for (std::size_t i = 0; i < possible.size(); ++i)
    text += (i == 0 ? "" : i + 1 == possible.size() ? " and " : ", ") + std::string(possible[i]);
  return text;
}

std::string orders_in_change(LinkKind kind) {
  constexpr std::string_view kOrders[] = {"status", "tool park", "tool measure", "jog", "probe", "unlock"};
  return possible_of(kind, kOrders);
}

std::string tool_off_advice(LinkKind kind, const config::ProgramFormat& format) {
  if (can_order(kind, "tool park") && format.retract == "none")
    return "`tiltfeed machine jog` takes the tool off: the profile states no retract line";
  if (can_order(kind, "tool park")) return "`tiltfeed machine tool park` takes the tool off";
  return std::string(can_order(kind, "reset")
                         ? "`tiltfeed reset` ends what the controller still has of its way; "
                         : "") +
         "take the tool off at the control";
}

std::string cut_way_advice(LinkKind kind, const config::ProgramFormat& format) {
  return "whether and where it stands is not known; " + tool_off_advice(kind, format);
}

std::string tool_by_hand_advice(LinkKind kind) {
  return can_order(kind, "tool") ? "`tiltfeed machine tool` is for a tool that no program waits for" : "";
}

std::string way_free_advice(LinkKind kind) {
  return "take the tool to where the way is free (" +
         std::string(can_order(kind, "jog") ? "`tiltfeed machine jog`" : "by hand at the control") + ")";
}

std::string forget_advice(LinkKind kind) {
  if (can_order(kind, "reset")) return "`tiltfeed reset` ends what the controller may still have of it";
  return "a reset at the control ends what it may still have of it";
}

std::string way_out_advice(LinkKind kind) {
  return can_order(kind, "reset") ? "`tiltfeed reset` leads out of it" : "lead it out of it at the control";
}

std::string still_advice(LinkKind kind) {
  return "where it moves all the same, " + std::string(can_order(kind, "reset")
                                                           ? "`tiltfeed reset` ends it"
                                                           : "a reset at the control ends it");
}

}  // namespace tiltfeed::daemon
