#pragma once
// A shop's tools in a file of their own, which jobs refer to by id. Every key: config/tools/example.yaml.

#include <string>
#include <vector>

#include "config/yaml_tree.h"
#include "kinematics/basics/result.h"
#include "pathgen/options/cutter.h"

namespace tiltfeed::config {

/// Of a tool in one material; 0: not stated.
struct CuttingData {
  std::string material;
  double spindle_rpm = 0.0;                ///< 1/min
  double cut_feed = 0.0, plunge_feed = 0;  ///< mm/min
  /// Where the feed follows the engagement: the most that it may be for each tooth, and the thickest chip,
  /// mm.
  double highest_tooth = 0.0, largest_chip = 0.0;
};

struct LibraryTool {
  std::string id, name, vendor, product;  ///< the last three may be empty
  TextPlace place;
  int number = 0;  ///< T of a program; 0: none
  int flutes = 0;  ///< 0: not stated
  pathgen::Cutter cutter;
  /// Keys of the form that are not there yet: an import knows no more. `cutter` is then of no use.
  std::vector<std::string> lacks;
  std::vector<CuttingData> data;
};

struct ToolLibrary {
  std::string path;
  std::vector<LibraryTool> tools;
};

/// Far more than a magazine, and no more than kMaxConfigBytes hold.
inline constexpr std::size_t kMostLibraryTools = 10'000;

/// Properties: ids differ; a tool that lacks nothing is right as a job's cutter is; materials of a tool
/// differ, and so do the feeds of cutting data from 0 that are stated.
/// Errors: kInput as file:line:column, what was expected, the nearest known key; kIo.
Result<ToolLibrary> load_tool_library(const std::string& path);
/// The same from text; `path` names it in messages.
Result<ToolLibrary> parse_tool_library(const std::string& text, const std::string& path);

}  // namespace tiltfeed::config
