#pragma once
// What a message may advise an operator to do: only what the link in use has. Texts that name a command of
// `tiltfeed machine`, or `tiltfeed reset`, for more than one kind of link get it here.

#include <span>
#include <string>
#include <string_view>

#include "config/program_format.h"
#include "daemon/program/link_kind.h"

namespace tiltfeed::daemon {

/// "jog", "tool park", "reset": whether it is possible over such a link.
bool can_order(LinkKind kind, std::string_view order);
/// "status, override and reset": those of `orders` that are possible; empty: none.
std::string possible_of(LinkKind kind, std::span<const std::string_view> orders);

/// What an operator may want of the machine while a tool is changed, as above; empty: nothing.
std::string orders_in_change(LinkKind kind);
/// Before a tool change, when a parking or a way back was cut off: how the tool comes off the part.
std::string tool_off_advice(LinkKind kind, const config::ProgramFormat& format);
/// After a service that ended, or a way off or back that was cut off.
std::string cut_way_advice(LinkKind kind, const config::ProgramFormat& format);
/// For who has no tool change to end; empty: nothing.
std::string tool_by_hand_advice(LinkKind kind);
/// For who is to take the tool by hand to where a way is free.
std::string way_free_advice(LinkKind kind);
/// How a controller forgets what it may still have of a job.
std::string forget_advice(LinkKind kind);
/// How a machine comes out of a state in which it takes no program.
std::string way_out_advice(LinkKind kind);
/// How a machine stands that moves although no job is on it.
std::string still_advice(LinkKind kind);

}  // namespace tiltfeed::daemon
