#pragma once
// The words of a control's high-speed function.

#include <optional>
#include <string_view>

#include "config/program_format.h"

namespace tiltfeed::sim {

/// Whether the line says nothing but words of this function: G5.1 Q, G187, CYCLE832, cycle 32, G62.
bool smooths(std::string_view line, config::Dialect dialect);
/// Whether it is on behind this line, where the line says so.
std::optional<bool> smoothing_after(std::string_view line, config::Dialect dialect);

/// What such a line lets the control leave the path by, in the program's unit; nothing: it says none.
std::optional<double> smoothing_within(std::string_view line, config::Dialect dialect);

/// Whether a mode that the line states is the one for this work; nothing: the line states none.
std::optional<bool> is_smoothing_mode(std::string_view line, config::Dialect dialect,
                                      config::Smoothing wanted);
/// By how much the control may lean the tool, degrees; nothing: the line says none.
std::optional<double> smoothing_leans(std::string_view line, config::Dialect dialect);

}  // namespace tiltfeed::sim
