#include "daemon/machine/machine_orders.h"

#include "daemon/machine/order_parts.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed {

namespace {

constexpr MachineOrder kOrders[] = {
    {"status", "", "state, machine and program position, rotaries unwound, overrides", true, LinkSet::kAll,
     order_status},
    {"jog", "AXIS.. [F] | AXIS+|AXIS- [F]",
     "move by mm or degrees (X-10 C90 F500); X+ or X- goes on as long as input comes (keys), and stops "
     "half a second after the last",
     false, LinkSet::kGrbl, order_jog},
    {"home", "[AXIS]", "home the machine, or one axis", false, LinkSet::kGrbl, order_home},
    {"unlock", "", "leave an alarm without homing ($X; ring: clear alarm)", false, LinkSet::kGrblAndRing,
     order_unlock},
    {"offsets", "[G54..G59.3 [here] AXIS..]",
     "show the work offsets; set one by value (G55 X-120.5), or so that the axes are here at these values "
     "(G55 here "
     "X0 Y0)",
     false, LinkSet::kGrbl, order_offsets},
    {"probe", "AXIS [F] [G54=VALUE]",
     "move until the probe touches (Z-20 F50), tell where; set a work offset so that this place has the "
     "value "
     "(G54=12, a plate's thickness)",
     false, LinkSet::kGrbl, order_probe},
    {"settings", "[set NUMBER=VALUE | save FILE | restore FILE | compare FILE]",
     "the controller's settings by name; set one; keep them in a file", false, LinkSet::kGrbl,
     order_settings},
    {"console", "LINE..",
     "a line to the controller as it is, and its answer: no limit of the profile is looked at", false,
     LinkSet::kGrbl, order_console},
    {"tool", "park | measure Z.. [F] setter=Z|length=MM | change",
     "park (spindle and coolant off, the profile's retract); measure a tool's length on a plate (setter: "
     "machine Z "
     "at which the gauge line would touch), or the plate with a tool of known length; change: guided, all of "
     "it",
     false, LinkSet::kGrbl, order_tool},
    {"override", "feed|rapid|spindle PERCENT", "10 to 200; rapid 25, 50 or 100 (ring: feed)", true,
     LinkSet::kGrblAndRing, order_override},
};

/// What there is over a link that is not Grbl's.
std::string what_can(LinkKind kind) {
  if (is_ring(kind)) return "over the ring status, unlock, override feed and `tiltfeed reset` are possible";
  if (kind == LinkKind::kDrip) return "over this link nothing but a program is";
  return "over this link `tiltfeed reset` is possible";
}

}  // namespace

std::span<const MachineOrder> machine_orders() { return kOrders; }

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
  const LinkKind kind = bench.link.kind;
  const bool can = order->links == LinkSet::kAll || kind == LinkKind::kGrbl ||
                   (order->links == LinkSet::kGrblAndRing && is_ring(kind));
  if (!can)
    return fail(Code::kUsage, std::string(order->name) + " needs a controller of the Grbl family; over " +
                                  describe(bench.link) + " it is done at the control; " + what_can(kind));
  return order->act(bench, words);
}

tl::unexpected<Error> wrong_words(const char* command, const std::string& what) {
  const MachineOrder* const order = find_machine_order(command);
  return fail(Code::kUsage, std::string(command) + ": " + what + "; it is `machine " + command +
                                (order != nullptr && *order->words != '\0' ? " " : "") +
                                (order != nullptr ? order->words : "") + "`");
}

}  // namespace tiltfeed
