#pragma once
// The tool as the page draws it: outlines of cutter, shank and holder.

#include <array>
#include <string>
#include <vector>

#include "pathgen/options/cutter.h"

namespace tiltfeed::desk {

/// Radius and height over the tip, mm, from below.
struct ToolOutline {
  const char* part = "cutter";  ///< cutter, shank, holder
  std::vector<std::array<double, 2>> points;
};

/// From the tip up. Of a tool without a holder: cutter and shank, as far as they are known.
std::vector<ToolOutline> tool_outline(const pathgen::Cutter& cutter);

}  // namespace tiltfeed::desk
