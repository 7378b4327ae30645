#pragma once
// A program that enters another one in the middle, in the words of a control of the machine shop: one that
// knows tool lengths, TCP and tilted planes by itself, changes tools, and does not say where it stands.

#include <string>

#include "config/machine_profile.h"
#include "daemon/journal/reentry_text.h"

namespace tiltfeed::daemon {

/// The way in is what the post itself writes for a program whose first place is over the entry. It begins
/// with safe words and the profile's retract. Tool, spindle, coolant, rotaries, X and Y follow, then work
/// offset, plane or TCP as they are in force there. From the first place it goes along the tool axis at
/// plunge feed to the end of the block before. The first place is `retract` higher along that axis than any
/// place of the program, or as high as the travel allows. Then the modes that are in force, and the program
/// from block `from` on as it stands. Properties: 1 Read back by read_nc_program() the way in ends with the
/// words of the block before, in the same plane, under TCP or not. 2 The blocks from `from` on are those of
/// the program. 3 What is in force before each of them is what is in force there in the program. Blocks are
/// lines, as DNC counts them. Errors: those of plan_reentry; kInput: a line that is not understood, a plane
/// with another origin, TCP or a plane without a header that states tool length and part zero; kUsage: the
/// block stands on a way to or from the retract (the message names the next one that can be entered), the
/// control shifts the tool to a side, `retract: none`.
Result<Reentry> plan_control_entry(const std::string& program, const config::MachineProfile& machine,
                                   const ReentryOptions& options);

}  // namespace tiltfeed::daemon
