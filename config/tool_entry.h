#pragma once
// Tools as other programs' files describe them.

#include <optional>
#include <string>
#include <vector>

#include "config/tool_library.h"

namespace tiltfeed::config {

/// A tool as far as its file says what it is; 0 and empty: not said.
struct ToolEntry {
  std::string id, name, vendor, product;
  int number = 0, flutes = 0;
  std::optional<pathgen::CutterType> type;
  double diameter = 0.0, corner_radius = 0.0, length = 0.0;               ///< mm
  double cutting_length = 0.0, shank_diameter = 0.0, shank_length = 0.0;  ///< mm
  std::vector<pathgen::HolderStep> holder;
  std::vector<CuttingData> data;
};

struct ToolImport {
  std::vector<ToolEntry> tools;
  std::vector<std::string> notes;  ///< what was left out or changed, a line each
};

struct ImportOptions {
  std::optional<double> unit_mm;  ///< of files that do not say theirs
};

}  // namespace tiltfeed::config
