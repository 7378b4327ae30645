#pragma once
// A picture of the part with the tool path over it, drawn without a display.

#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh.h"
#include "sim/picture/facet_marks.h"

namespace tiltfeed::sim {

struct PictureOptions {
  int width = 1600, height = 1000;  ///< px
  int passes = 60;                  ///< about so many are drawn, evenly chosen, when there are more
  int axes = 90;                    ///< places on the drawn passes where the tool axis is shown
  bool rapids = true;
  /// Of each facet of the part: unreached ones are violet, their edges seen through the part, uncut ones
  /// blue; empty: none is marked.
  std::vector<FacetMark> marks;
};

/// Draws the part shaded, seen from where the tool comes from; cutting moves over it, from yellow (first) to
/// crimson (last), rapids dashed, tool axes as short dark lines. The same input gives the same picture.
/// The bytes of a PNG file. Errors: kInput when the part has no facets; kIo.
Result<std::string> part_with_path(const pathgen::Mesh& part, const ToolPath& path,
                                   const PictureOptions& options = {});
/// Writes it into a file. Errors: likewise.
Result<void> draw_part_with_path(const pathgen::Mesh& part, const ToolPath& path, const std::string& png_path,
                                 const PictureOptions& options = {});

}  // namespace tiltfeed::sim
