#include "daemon/machine/machine_orders.h"

#include "daemon/machine/order_parts.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

constexpr MachineOrder kOrders[] = {
    {"status", "", "state, machine and program position, rotaries unwound, overrides", true, grbl_status,
     reprap_status, ring_status, drive_status},
    {"jog", "AXIS.. [F] | AXIS+|AXIS- [F]",
     "move by mm or degrees (X-10 C90 F500); X+ or X- goes on as long as input comes (keys), and stops "
     "half a second after the last",
     false, grbl_jog, reprap_jog},
    {"home", "[AXIS]", "home the machine, or one axis", false, grbl_home, reprap_home},
    {"unlock", "", "leave an alarm without homing ($X; RepRap: M999; ring: clear alarm)", false, grbl_unlock,
     reprap_unlock, ring_unlock},
    {"offsets", "[G54..G59.3 [here] AXIS..]",
     "show the work offsets; set one by value (G55 X-120.5), or so that the axes are here at these values "
     "(G55 here X0 Y0; RepRap: G92 here, too)",
     false, grbl_offsets, reprap_offsets},
    {"probe", "AXIS [F] [G54=VALUE]",
     "move until the probe touches (Z-20 F50), tell where; set a work offset so that this place has the "
     "value (G54=12, a plate's thickness)",
     false, grbl_probe},
    {"settings", "[set NUMBER=VALUE | set CODE WORDS | save FILE | restore FILE | compare FILE]",
     "show the controller's settings by name; set one ($110=500; RepRap: M203 X500); save them to FILE; "
     "restore or list (compare) those that differ from FILE",
     false, grbl_settings, reprap_settings},
    {"console", "LINE..",
     "a line to the controller as it is, and its answer: no limit of the profile is looked at", false,
     grbl_console, reprap_console},
    {"tool", "park | measure Z.. [F] setter=Z|length=MM | change",
     "park (spindle and coolant off, the profile's retract); measure a tool's length on a plate (setter: "
     "machine Z at which the gauge line would touch), or the plate with a tool of known length; change: "
     "guided, all of it",
     false, grbl_tool, reprap_tool},
    {"override", "feed|rapid|spindle PERCENT",
     "run at PERCENT of the programmed feed, rapid or spindle speed from now on, while a program runs too: "
     "10 to 200, rapid 25, 50 or 100; 100 is as programmed (RepRap and ring: feed only)",
     true, grbl_override, reprap_override, ring_override},
};

/// What there is over a link.
std::string what_can(LinkKind kind) {
  if (kind == LinkKind::kDrip) return "nothing but a program is sent there";
  std::string names;
  for (const MachineOrder& one : kOrders)
    if (deed_of(one, kind) != nullptr) names += std::string(one.name) + ", ";
  return names + "and `tiltfeed reset` are possible there";
}

}  // namespace

std::span<const MachineOrder> machine_orders() { return kOrders; }

MachineDeed deed_of(const MachineOrder& order, LinkKind kind) {
  if (kind == LinkKind::kGrbl) return order.grbl;
  if (kind == LinkKind::kRepRap) return order.reprap;
  if (is_ring(kind)) return order.ring;
  return is_drive(kind) ? order.drive : nullptr;
}

const MachineOrder* find_machine_order(std::string_view name) {
  for (const MachineOrder& one : kOrders)
    if (name == one.name) return &one;
  return nullptr;
}

Result<MachineAnswer> perform_order(const MachineBench& bench, std::string_view name,
                                    const std::vector<std::string>& words) {
  const MachineOrder* const order = find_machine_order(name);
  if (order == nullptr)
    return fail(Code::kUsage,
                "'" + wire_text(name) + "' is no command for a machine; see tiltfeed machine --help");
  const MachineDeed act = deed_of(*order, bench.link.kind);
  if (act == nullptr)
    return fail(Code::kUsage, std::string(order->name) + " is not possible over " + describe(bench.link) +
                                  ", do it at the control; " + what_can(bench.link.kind));
  return act(bench, words);
}

tl::unexpected<Error> wrong_words(const char* command, const std::string& what) {
  const MachineOrder* const order = find_machine_order(command);
  return fail(Code::kUsage, std::string(command) + ": " + what + "; it is `machine " + command +
                                (order != nullptr && *order->words != '\0' ? " " : "") +
                                (order != nullptr ? order->words : "") + "`");
}

}  // namespace tiltfeed::daemon
